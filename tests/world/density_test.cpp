// Density fields: the sparse grid, and what of an OpenVDB file becomes one.
#include "world/density.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "catch.h"
#include "is_refused.h"
#include "temporary_folder.h"
#include "write_vdb.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// Linear in the index within [0, 30] x [-20, 10] x [5, 9], a gap cut into it.
float ramp(int x, int y, int z) {
  const bool inside = x >= 0 && x <= 30 && y >= -20 && y <= 10 && z >= 5 && z <= 9;
  const bool gap = x >= 8 && x <= 24 && y >= -16 && y <= 8;
  return inside && !gap ? 1 + 0.1f * x + 0.02f * y + 0.3f * z : 0;
}

DensityGrid ramp_grid() {
  DensitySource source;
  source.low = {0, -20, 5};
  source.high = {30, 10, 9};
  source.is_empty = [](std::array<int, 3>) { return false; };
  source.fill = [](std::array<int, 3> first, float* samples) {
    for (int i = 0; i < DensityGrid::kBrickSamples; ++i) {
      samples[i] = ramp(first[0] + i % 9, first[1] + i / 9 % 9, first[2] + i / 81);
    }
  };
  return *make_density_grid(source, {}, 1);
}

std::string message_of(const std::filesystem::path& file, const std::string& grid = "density") {
  const auto density = load_density_vdb(file, grid);
  if (density.ok()) return "";
  CHECK(density.error().kind == ErrorKind::usage);
  CHECK(density.error().message.starts_with(file.string() + ": "));
  return density.error().message;
}

}  // namespace

// Protects the seams between bricks, the cells around the outermost samples and negative indices:
// on samples, between them and outside.
TEST_CASE("a density grid is its samples, linear in between, zero beyond") {
  const DensityGrid grid = ramp_grid();
  for (int z = 3; z < 12; ++z) {
    for (int y = -23; y < 13; ++y) {
      for (int x = -3; x < 34; ++x) {
        REQUIRE(density_at(grid, {double(x), double(y), double(z)}) == Approx(ramp(x, y, z)));
        const float middle =
            (ramp(x, y, z) + ramp(x + 1, y, z) + ramp(x, y + 1, z) + ramp(x + 1, y + 1, z)) / 4;
        REQUIRE(density_at(grid, {x + 0.5, y + 0.5, double(z)}) ==
                Approx(middle).epsilon(1e-6).margin(1e-6));
      }
    }
  }
  CHECK(density_at(grid, {1e9, 0, 6}) == 0);
  CHECK(density_at(grid, {std::numeric_limits<double>::quiet_NaN(), 0, 6}) == 0);
}

TEST_CASE("bricks without density take no room") {
  const DensityGrid grid = ramp_grid();
  std::size_t empty = 0;
  for (const std::int32_t brick : grid.top) empty += brick < 0;
  CHECK(grid.top.size() == 5u * 5 * 2);  // cells -1 ... 30, -21 ... 10, 4 ... 9
  CHECK(empty > 0);
  CHECK(grid.samples.size() == (grid.top.size() - empty) * 729);
}

TEST_CASE("grids that are too large are refused") {
  DensitySource source;
  source.high = {3000, 3000, 3000};
  source.is_empty = [](std::array<int, 3>) { return true; };
  const auto wide = make_density_grid(source, {}, 1);
  CHECK(is_refused(wide, "2048^3 voxels"));
  source.high = {1000, 1000, 1000};
  source.is_empty = [](std::array<int, 3>) { return false; };
  const auto dense = make_density_grid(source, {}, 1);
  CHECK(is_refused(dense, "at most 524288"));
}

// Protects the way of a file into the grid: leaves and tiles, values, transform, the grid's name.
TEST_CASE("an OpenVDB grid is read with its values and its place") {
  const TemporaryFolder folder;
  VdbGrid other{"other", 0.2, {}, 0, VdbKind::vectors, false, {{{0, 0, 0}, {1, 1, 1}, 5}}};
  VdbGrid grid{"smoke", 0.25, {1, 2, 3}, 0, VdbKind::fog, false, {}};
  grid.boxes = {{{-40, 0, 0}, {40, 3, 3}, 0.5f}, {{2, 2, 2}, {2, 2, 2}, 7}};
  write_vdb(folder.path() / "a.vdb", {other, grid});
  const auto density = load_density_vdb(folder.path() / "a.vdb", "smoke");
  REQUIRE(density.ok());
  CHECK(density->spacing_m == Approx(0.25));
  const auto at = [&](Vec3 p) {
    return density_at(*density, mapped(density->index_from_local, p));
  };
  CHECK(at({1 + 0.5, 2 + 0.5, 3 + 0.5}) == Approx(7));
  CHECK(at({1 - 0.25 * 40, 2, 3}) == Approx(0.5));
  CHECK(at({1 + 0.25 * 40, 2.75, 3.75}) == Approx(0.5));
  CHECK(at({1 + 0.25 * 40.5, 2.3, 3.3}) == Approx(0.25));
  CHECK(at({1 + 0.25 * 41, 2.3, 3.3}) == Approx(0).margin(1e-6));
}

// A tile of OpenVDB's own (128^3 voxels of one value) is one value there and bricks here.
TEST_CASE("tiles of one value are read") {
  const TemporaryFolder folder;
  VdbGrid grid;
  grid.boxes = {{{0, 0, 0}, {127, 127, 127}, 0.25f}};
  write_vdb(folder.path() / "a.vdb", {grid});
  const auto density = load_density_vdb(folder.path() / "a.vdb", "density");
  REQUIRE(density.ok());
  for (const double u : {0.0, 1.5, 64.0, 126.9, 127.0}) {
    CHECK(density_at(*density, {u, 127 - u, 50}) == Approx(0.25));
  }
  CHECK(density_at(*density, {-0.5, 3, 3}) == Approx(0.125));
}

TEST_CASE("wrong grids are refused with the reason") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.vdb";
  const auto with = [&](VdbGrid grid) {
    if (grid.boxes.empty()) grid.boxes = {{{0, 0, 0}, {3, 3, 3}, 1}};
    write_vdb(file, {grid});
    return message_of(file);
  };
  const auto says = [](const std::string& message, const std::string& part) {
    INFO(message);
    CHECK(message.find(part) != std::string::npos);
  };
  VdbGrid grid;
  grid.name = "smoke";
  says(with(grid), "has no grid `density`; expected one of smoke");
  grid.name = "density";
  grid.kind = VdbKind::level_set;
  says(with(grid), "is a level set; expected a fog volume");
  grid.kind = VdbKind::doubles;
  says(with(grid), "holds double; expected a grid of float");
  grid.kind = VdbKind::fog;
  grid.background = 1;
  says(with(grid), "has the background 1; expected 0");
  grid.background = 0;
  grid.frustum = true;
  says(with(grid), "expected a linear transform");
  grid.frustum = false;
  grid.boxes = {{{0, 0, 0}, {3, 3, 3}, -1}};
  says(with(grid), "holds the density -1; expected 0 to 1000000");
  grid.boxes = {{{0, 0, 0}, {3, 3, 3}, std::numeric_limits<float>::quiet_NaN()}};
  says(with(grid), "holds the density nan");
  grid.boxes = {{{0, 0, 0}, {0, 0, 0}, 1}, {{100000, 100000, 0}, {100000, 100000, 0}, 1}};
  says(with(grid), "extends over more than 2048^3 voxels");
  grid.boxes = {{{2000000000, 0, 0}, {2000000000, 0, 0}, 1}};
  says(with(grid), "has voxels beyond index");
  grid.boxes = {{{3, 3, 3}, {0, 0, 0}, 1}};
  says(with(grid), "has no active voxel");
}

// Protects the exit status: no file makes the program end otherwise than with a usage error.
TEST_CASE("broken OpenVDB files are refused") {
  const TemporaryFolder folder;
  VdbGrid grid;
  grid.boxes = {{{0, 0, 0}, {40, 40, 40}, 1}, {{5, 5, 5}, {9, 9, 9}, 0.3f}};
  write_vdb(folder.path() / "whole.vdb", {grid});
  std::ifstream stream(folder.path() / "whole.vdb", std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(stream), {}};
  REQUIRE(whole.size() > 2000);
#if !defined(ENSONIFY_SANITIZED)
  // OpenVDB takes the size of a block from where the file ends and asks for that much memory. Where
  // `new` cannot throw, as under these sanitizers, the program ends there.
  for (std::size_t part = 0; part < 40; ++part) {
    const auto file = folder.write("cut.vdb", whole.substr(0, whole.size() * part / 40));
    INFO(part << " of 40");
    CHECK_FALSE(message_of(file).empty());
  }
#endif
  CHECK_FALSE(message_of(folder.write("text.vdb", std::string(5000, 'x'))).empty());
  CHECK_FALSE(message_of(folder.path() / "none.vdb").empty());
}
