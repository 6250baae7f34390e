#include "labels/cartesian.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "catch.h"
#include "core/image_planes.h"
#include "core/units.h"
#include "labels/shadow.h"

using namespace ensonify;

namespace {

Sonar fan(double fov_deg) {
  Sonar sonar;
  sonar.bandwidth_hz = 30e3;
  sonar.range_max_m = 10;
  sonar.beam_count = 90;
  sonar.beam_spacing_rad = radians(fov_deg) / 90;
  return sonar;
}

const Water kWater{1500, 0};

template <class Value>
Value sample_of(const std::vector<Value>&, int value) {
  return static_cast<Value>(value);
}

}  // namespace

TEST_CASE("the grid holds the whole fan") {
  const CartesianGrid narrow = cartesian_grid(fan(60), 500);
  CHECK(narrow.m_per_px == Approx(0.02));
  CHECK(narrow.width_px == 500);
  CHECK(narrow.x_top_m == Approx(10));
  CHECK(narrow.y_left_m == Approx(5));
  CHECK(cartesian_grid(fan(180), 500).width_px == 1000);
}

// Protects the bytes of every picture: borders of sectors are met pixel by pixel (the middle one by
// a column of pixels, the diagonals by corners), and no short cut may decide them otherwise.
TEST_CASE("every pixel is that of the arc tangent") {
  for (const double fov_deg : {20.0, 60.0, 90.0, 130.0, 180.0, 240.0, 360.0}) {
    for (const int beams : {1, 90, 127, 512}) {
      Sonar sonar = fan(fov_deg);
      sonar.beam_count = beams;
      sonar.beam_spacing_rad = radians(fov_deg) / beams;
      const Record record = make_record(sonar, kWater, 0);
      for (const int height_px : {1, 201, 300}) {
        const CartesianGrid grid = cartesian_grid(sonar, height_px);
        const auto map = cartesian_map(grid, sonar, kWater, record);
        int other = 0, at = 0;
        for (int row = 0; row < grid.height_px; ++row) {
          for (int column = 0; column < grid.width_px; ++column) {
            const double x = grid.x_top_m - (row + 0.5) * grid.m_per_px;
            const double y = grid.y_left_m - (column + 0.5) * grid.m_per_px;
            const auto beam = sector_of(sonar, std::atan2(y, x));
            const long sample = std::lround(std::hypot(x, y) * (2.0 * 30e3 / 1500));
            const bool inside = beam && sample < record.samples;
            other += map[at++] != (inside ? sample * beams + *beam : -1);
          }
        }
        INFO(fov_deg << " degrees, " << beams << " beams, " << height_px << " rows");
        CHECK(other == 0);
      }
    }
  }
}

TEST_CASE("outside the fan there is nothing") {
  LabelledImage polar;
  polar.rows = polar.columns = 1;
  int value = 0;  // another in each plane
  for (const ImagePlane& plane : kImagePlanes) {
    ++value;
    with_plane(polar, plane, [&](auto& values) { values.assign(1, sample_of(values, value)); });
  }
  CartesianGrid grid;
  grid.height_px = 1;
  grid.width_px = 2;
  const LabelledImage image = resample(polar, grid, {0, -1});
  value = 0;
  for (const ImagePlane& plane : kImagePlanes) {
    INFO(plane.name);
    ++value;
    with_plane(image, plane, [&](const auto& values) {
      REQUIRE(values.size() == 2);
      CHECK(values[0] == sample_of(values, value));
    });
  }
  CHECK(image.level_db[1] == kNoEnergyDb);
  CHECK(image.clean_db[1] == kNoEnergyDb);
  CHECK(std::isnan(image.elevation_rad[1]));
  CHECK(std::isnan(image.elevation_std_rad[1]));
  CHECK(image.instance_fraction[1] == 0);
  CHECK(image.instance[1] == 0);
  CHECK(image.semantic[1] == 0);
  CHECK(image.shadow[1] == 0);
  CHECK(image.multipath[1] == 0);
}

// Protects every plane and the sets of instances against the definition, over several tiles: what
// is not blank is rare, alone in its plane, and also where no echo is heard.
TEST_CASE("every plane shows the polar pixel of the map") {
  Sonar sonar = fan(130);
  const Record record = make_record(sonar, kWater, 0);
  const CartesianGrid grid = cartesian_grid(sonar, 150);
  const auto map = cartesian_map(grid, sonar, kWater, record);
  LabelledImage polar;
  polar.rows = record.samples;
  polar.columns = sonar.beam_count;
  const auto pixels = static_cast<std::uint32_t>(polar.rows * polar.columns);
  std::uint32_t number = 0;
  for (const ImagePlane& plane : kImagePlanes) {
    ++number;
    with_plane(polar, plane, [&](auto& values) {
      using Value = typename std::decay_t<decltype(values)>::value_type;
      values.assign(pixels, blank_value<Value>(plane.blank));
      for (std::uint32_t i = number; i < pixels; i += 97) values[i] = static_cast<Value>(i % 200);
    });
  }
  InstanceSets sets;
  sets.set.resize(pixels);
  for (std::uint32_t i = 0; i < pixels; i += 101) sets.set[i] = i;
  const std::vector<std::uint32_t> polar_sets = sets.set;
  const auto planes = GENERATE(ResampledPlanes::all, ResampledPlanes::ids);
  const LabelledImage image = resample(polar, grid, map, planes, &sets);
  CHECK(sets.rows == grid.height_px);
  CHECK(sets.columns == grid.width_px);
  REQUIRE(sets.set.size() == map.size());
  std::size_t shown = 0, different = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    const std::uint32_t expected = map[i] < 0 ? 0 : polar_sets[map[i]];
    shown += expected != 0;
    different += sets.set[i] != expected;
  }
  for (const ImagePlane& plane : kImagePlanes) {
    if (planes == ResampledPlanes::ids && is_float_plane(plane)) continue;
    std::visit(
        [&](auto member) {
          using Value = typename std::decay_t<decltype(image.*member)>::value_type;
          const Value blank = blank_value<Value>(plane.blank);
          REQUIRE((image.*member).size() == map.size());
          for (std::size_t i = 0; i < map.size(); ++i) {
            const Value expected = map[i] < 0 ? blank : (polar.*member)[map[i]];
            different += std::memcmp(&(image.*member)[i], &expected, sizeof expected) != 0;
          }
        },
        plane.values);
  }
  CHECK(shown > 100);
  CHECK(different == 0);
}

// Protects time: float planes that nobody asked for are left out, and ids are the same without.
TEST_CASE("ids are resampled alone where nobody needs the float planes") {
  LabelledImage polar;
  polar.rows = 1;
  polar.columns = 3;
  for (const ImagePlane& plane : kImagePlanes) {
    with_plane(polar, plane, [&](auto& values) {
      for (const int value : {7, 8, 9}) values.push_back(sample_of(values, value));
    });
  }
  CartesianGrid grid;
  grid.height_px = 2;
  grid.width_px = 2;
  const std::vector<std::int32_t> map = {2, -1, 0, 1};
  const LabelledImage all = resample(polar, grid, map);
  const LabelledImage ids = resample(polar, grid, map, ResampledPlanes::ids);
  CHECK(ids.rows == 2);
  CHECK(ids.columns == 2);
  for (const ImagePlane& plane : kImagePlanes) {
    INFO(plane.name);
    std::visit(
        [&](auto values) {
          if (is_float_plane(plane)) {
            CHECK((ids.*values).empty());
          } else {
            CHECK(ids.*values == all.*values);
            CHECK((ids.*values).front() == 9);
          }
        },
        plane.values);
  }
}

// Protects the copying from planes that are shorter than the image.
TEST_CASE("an image without one of its planes is not resampled") {
  LabelledImage polar;
  polar.rows = polar.columns = 1;
  CartesianGrid grid;
  grid.height_px = grid.width_px = 1;
  CHECK_THROWS_AS(resample(polar, grid, {0}), std::logic_error);
}
