// A ray's way through volumes, against closed forms and against the plain way.
#include "trace/volume.h"

#include <cmath>
#include <numeric>

#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "temporary_folder.h"
#include "world/density.h"
#include "write_vdb.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr double kMarchStep_m = 0.0125;

Volume box_volume(Vec3 half, Pose pose = {}) { return {1, 1, 1, DensityBox{half}, pose}; }

Volume grid_volume(const DensityGrid& grid, Pose pose = {}) {
  return {1, 1, 1, std::make_shared<const DensityGrid>(grid), pose};
}

double total(const DensityColumn& column) {
  return std::accumulate(column.length_m.begin(), column.length_m.end(), 0.0);
}

// Bricks of random samples with large gaps, in voxels of 0.03 m.
DensityGrid patchy_grid() {
  DensitySource source;
  source.low = {-30, -20, -25};
  source.high = {40, 50, 25};
  source.is_empty = [](std::array<int, 3>) { return false; };
  source.fill = [](std::array<int, 3> first, float* samples) {
    for (int i = 0; i < DensityGrid::kBrickSamples; ++i) {
      const int x = first[0] + i % 9, y = first[1] + i / 9 % 9, z = first[2] + i / 81;
      const bool within = x >= -30 && x <= 40 && y >= -20 && y <= 50 && z >= -25 && z <= 25;
      const bool patch = (x / 11 + y / 13 + z / 7) % 4 == 0;
      const auto item = std::uint64_t(x + 100) << 20 | std::uint64_t(y + 100) << 10 | (z + 100);
      samples[i] = within && patch ? static_cast<float>(uniform(7, 0, item, 0)) : 0;
    }
  };
  Affine affine;
  for (int i = 0; i < 3; ++i) affine.rows[i] = (1 / 0.03) * affine.rows[i];
  affine.offset = {0.3, -0.7, 0.1};
  return *make_density_grid(source, affine, 0.03);
}

Vec3 any_direction(std::uint64_t i) {
  const double z = 2 * uniform(1, 0, i, 0) - 1, turn = 2 * kPi * uniform(1, 0, i, 1);
  return {std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z};
}

}  // namespace

// A box 2 m long whose near face is 3 m away: nothing before, nothing behind, whole steps within;
// turned by 30 degrees about z it is as much longer as the cosine says.
TEST_CASE("a ray through a box") {
  DensityColumn column;
  march(box_volume({1, 5, 5}, {{4.001, 0, 0}, {}}), {{}, {1, 0, 0}}, kMarchStep_m, 20, column);
  CHECK(total(column) == Approx(2));
  CHECK(column.first == 240);
  CHECK(column.last == 401);
  CHECK(column.length_m[240] == Approx(0.0115));
  CHECK(column.length_m[300] == Approx(kMarchStep_m));
  CHECK(column.length_m[400] == Approx(0.001));
  const Pose turned{{4, 0, 0}, from_roll_pitch_yaw(0, 0, radians(30))};
  march(box_volume({1, 5, 5}, turned), {{}, {1, 0, 0}}, kMarchStep_m, 20, column);
  CHECK(total(column) == Approx(2 / std::cos(radians(30))));
  march(box_volume({1, 5, 5}, turned), {{}, {1, 0, 0}}, kMarchStep_m, 4, column);
  CHECK(total(column) == Approx(1 / std::cos(radians(30))));
}

TEST_CASE("rays that start inside, end early, run along a face or miss") {
  DensityColumn column;
  const Volume box = box_volume({1, 1, 1});
  march(box, {{}, {0, 1, 0}}, kMarchStep_m, 20, column);
  CHECK(total(column) == Approx(1));
  march(box, {{}, {0, 1, 0}}, kMarchStep_m, 0.3, column);
  CHECK(total(column) == Approx(0.3));
  march(box, {{-5, 1.0000001, 0}, {1, 0, 0}}, kMarchStep_m, 20, column);
  CHECK(total(column) == 0);
  march(box, {{-5, 0, 0}, {-1, 0, 0}}, kMarchStep_m, 20, column);
  CHECK(total(column) == 0);
  march(box, {{}, {0, 1, 0}}, kMarchStep_m, std::nan(""), column);
  CHECK(total(column) == 0);
  march({1, 1, 1, {}, {}}, {{}, {0, 1, 0}}, kMarchStep_m, 7.1, column);
  CHECK(total(column) == Approx(7.1));
}

// The plain way: the density at the middle of every part of every step, wherever it is.
TEST_CASE("skipping empty bricks changes nothing") {
  const DensityGrid grid = patchy_grid();
  std::size_t empty = 0;
  for (const std::int32_t brick : grid.top) empty += brick < 0;
  REQUIRE(empty > grid.top.size() / 10);
  const Pose pose{{0.5, 0.2, -0.3}, from_roll_pitch_yaw(0.2, 0.4, 0.6)};
  const Volume volume = grid_volume(grid, pose);
  for (const double step_m : {0.0125, 0.1}) {  // in one part, and in four
    const int parts = static_cast<int>(std::ceil(step_m / 0.03));
    for (std::uint64_t i = 0; i < 60; ++i) {
      const Ray ray{{-1.5 + 0.05 * double(i), 0.3, 0.2}, i == 0 ? Vec3{1, 0, 0} : any_direction(i)};
      const double end_m = 2.987;
      DensityColumn column;
      march(volume, ray, step_m, end_m, column);
      std::vector<double> plain(static_cast<std::size_t>(end_m / step_m) + 2, 0.0);
      const double part_m = step_m / parts;
      for (int p = 0; p * part_m < end_m; ++p) {
        const double to = std::min((p + 1) * part_m, end_m), middle = (p * part_m + to) / 2;
        const Vec3 local = inverse_transform_point(pose, ray.origin_m + middle * ray.direction);
        plain[p / parts] +=
            density_at(grid, mapped(grid.index_from_local, local)) * (to - p * part_m);
      }
      for (std::size_t k = 0; k < plain.size(); ++k) {
        const double found = k < column.length_m.size() ? column.length_m[k] : 0;
        REQUIRE(found == Approx(plain[k]).epsilon(1e-4).margin(1e-7));
      }
    }
  }
}

// Rays along the axes run along seams between bricks, where each part must be counted once.
TEST_CASE("seams between bricks count once") {
  const TemporaryFolder folder;
  VdbGrid vdb;
  vdb.boxes = {{{0, 0, 0}, {63, 63, 63}, 1}};
  write_vdb(folder.path() / "a.vdb", {vdb});
  const Volume volume = grid_volume(*load_density_vdb(folder.path() / "a.vdb", "density"));
  for (const double y : {0.8, 1.6, 3.2, 3.0}) {
    for (const double sign : {1.0, -1.0}) {
      DensityColumn column;
      march(volume, {{sign > 0 ? -1.0 : 7.0, y, 2.4}, {sign, 0, 0}}, 0.1, 9, column);
      CHECK(total(column) == Approx(6.4).epsilon(1e-6));
      march(volume, {{y, 2.4, sign > 0 ? -1.0 : 7.0}, {0, 0, sign}}, 0.05, 9, column);
      CHECK(total(column) == Approx(6.4).epsilon(1e-6));
    }
  }
}

TEST_CASE("extinctions of several volumes add up") {
  DensityColumn column;
  std::vector<Volume> volumes = {box_volume({1, 1, 1}, {{3, 0, 0}, {}}),
                                 box_volume({1, 1, 1}, {{4, 0, 0}, {}}),
                                 {1, 1, 0.5, {}, {}}};
  volumes[1].extinction_db_m = 3;
  const Ray ray{{}, {1, 0, 0}};
  CHECK(extinction_db(volumes, ray, kMarchStep_m, 2, column) == Approx(1));
  CHECK(extinction_db(volumes, ray, kMarchStep_m, 3.5, column) == Approx(1.5 + 1.5 + 1.75));
  CHECK(extinction_db(volumes, ray, kMarchStep_m, 9, column) == Approx(2 + 6 + 4.5));
}
