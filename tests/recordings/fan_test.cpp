// Protects images of fans whose beams are not equally spaced and whose ranges begin after 0. With
// equal azimuths given one by one, all results are those of the spacing.
#include <algorithm>
#include <cmath>
#include <vector>

#include "catch.h"
#include "core/sonar.h"
#include "core/units.h"
#include "figure/paint.h"
#include "labels/cartesian.h"
#include "labels/cartesian_display.h"

namespace ensonify {
namespace {

Sonar equal_fan() {
  Sonar sonar;
  sonar.bandwidth_hz = 15'000;
  sonar.range_max_m = 5;
  sonar.beam_count = 40;
  sonar.beam_spacing_rad = 0.03;
  return sonar;
}

Sonar listed(Sonar sonar) {
  sonar.azimuth_rad = beam_azimuths_rad(sonar);
  return sonar;
}

Sonar unequal_fan() {
  Sonar sonar = equal_fan();
  for (int j = 0; j < 40; ++j) sonar.azimuth_rad.push_back(0.6 * std::sin((j - 19.5) / 20 * 1.2));
  sonar.beam_spacing_rad = (sonar.azimuth_rad.back() - sonar.azimuth_rad.front()) / 39;
  sonar.first_range_m = 2;
  return sonar;
}

}  // namespace

TEST_CASE("listed azimuths give the places and sectors of the spacing") {
  const Sonar equal = equal_fan(), same = listed(equal);
  for (double azimuth = -0.7; azimuth < 0.7; azimuth += 0.00713) {
    CHECK(beam_place(same, azimuth) == Approx(beam_place(equal, azimuth)).margin(1e-9));
    CHECK(sector_of(same, azimuth) == sector_of(equal, azimuth));
  }
  CHECK(furthest_azimuth_rad(same) == Approx(furthest_azimuth_rad(equal)));
}

TEST_CASE("sectors of unequal beams end halfway between them") {
  const Sonar sonar = unequal_fan();
  const auto borders = beam_borders_rad(sonar);
  REQUIRE(borders.size() == 41);
  for (int j = 0; j < 40; ++j) {
    CHECK(sector_of(sonar, sonar.azimuth_rad[j]) == j);
    CHECK(sector_of(sonar, borders[j] + 1e-9) == j);
    CHECK(sector_of(sonar, borders[j + 1] - 1e-9) == j);
  }
  CHECK_FALSE(sector_of(sonar, borders.front() - 1e-9));
  CHECK_FALSE(sector_of(sonar, borders.back() + 1e-9));
}

TEST_CASE("Cartesian pixels show the nearest beam and sample of an unequal fan, and lie between") {
  const Sonar sonar = unequal_fan();
  const Water water;
  Record record;
  record.samples = 61;
  const CartesianGrid grid = cartesian_grid(sonar, 150);
  const auto map = cartesian_map(grid, sonar, water, record);
  const double step = range_step_m(sonar, water);
  std::size_t shown = 0;
  for (int row = 0; row < grid.height_px; ++row) {
    for (int column = 0; column < grid.width_px; ++column) {
      const double x = grid.x_top_m - (row + 0.5) * grid.m_per_px;
      const double y = grid.y_left_m - (column + 0.5) * grid.m_per_px;
      const std::int32_t from = map[static_cast<std::size_t>(row * grid.width_px + column)];
      const double range = std::hypot(x, y), azimuth = std::atan2(y, x);
      if (range < 2 - step / 2 || range > 5 + step / 2) CHECK(from < 0);
      if (from < 0) continue;
      ++shown;
      CHECK(std::abs(sample_range_m(sonar, water, from / 40) - range) <= step / 2 + 1e-9);
      const auto nearest = std::min_element(
          sonar.azimuth_rad.begin(), sonar.azimuth_rad.end(),
          [&](double a, double b) { return std::abs(a - azimuth) < std::abs(b - azimuth); });
      CHECK(std::abs(azimuth - sonar.azimuth_rad[static_cast<std::size_t>(from % 40)]) <=
            std::abs(azimuth - *nearest) + 1e-9);
    }
  }
  // The area of the sector between 2 and 5 m.
  const double pixels = furthest_azimuth_rad(sonar) * (25 - 4) / (grid.m_per_px * grid.m_per_px);
  CHECK(static_cast<double>(shown) == Approx(pixels).epsilon(0.02));
  CHECK(is_grid_of_fan(grid, sonar, water, record));

  // Footprints lie at their pixel: means of places, weighted as intensities are.
  const Footprints f = footprints(grid, sonar, water, record, map);
  const std::size_t narrow = f.beam_fraction.size(), taps = static_cast<std::size_t>(f.taps);
  REQUIRE(narrow > f.to.size() / 2);
  for (std::size_t i = 0; i < narrow; i += 7) {
    const double x = grid.x_top_m - (f.to[i] / grid.width_px + 0.5) * grid.m_per_px;
    const double y = grid.y_left_m - (f.to[i] % grid.width_px + 0.5) * grid.m_per_px;
    const std::size_t beam = f.from[i] / f.line;
    const double along = f.beam_fraction[i] / 32768.0;
    const double azimuth =
        (1 - along) * sonar.azimuth_rad[beam] +
        along * sonar.azimuth_rad[std::min<std::size_t>(beam + 1, sonar.azimuth_rad.size() - 1)];
    const double inside =
        std::clamp(std::atan2(y, x), sonar.azimuth_rad.front(), sonar.azimuth_rad.back());
    CHECK(azimuth == Approx(inside).margin(2e-6));
    double sample = 0, sum = 0;
    for (std::size_t k = 0; k < taps; ++k) {
      const double weight = f.sample_weight[i * taps + k] * static_cast<double>(f.scale) / 32768;
      sample += weight * static_cast<double>(f.from[i] % f.line + k);
      sum += weight;
    }
    CHECK(sum == Approx(1));
    const double range = 2 + sample * range_step_m(sonar, water);
    CHECK(range == Approx(std::clamp(std::hypot(x, y), 2.0, 5.0)).margin(1e-5));
  }
}

TEST_CASE("figures place unequal beams by their azimuths") {
  const Sonar sonar = unequal_fan();
  PolarFan fan{sonar.azimuth_rad[0], sonar.beam_spacing_rad, 2, 0.05, 40, 61, sonar.azimuth_rad};
  for (int j = 0; j < 40; ++j) CHECK(fan.column_at(sonar.azimuth_rad[j]) == Approx(j).margin(1e-9));
  const auto borders = beam_borders_rad(sonar);
  CHECK(fan.min_azimuth_rad() == Approx(borders.front()));
  CHECK(fan.max_azimuth_rad() == Approx(borders.back()));
  // The axis of a polar figure is linear in azimuth.
  const auto cells = polar_cells(fan, 200, 10);
  for (int x = 0; x < 200; ++x) {
    const double azimuth = borders.front() + (borders.back() - borders.front()) * (x + 0.5) / 200;
    const double column = std::clamp(fan.column_at(azimuth), 0.0, 39.0);
    CHECK(cells[static_cast<std::size_t>(x)].column == Approx(column).margin(1e-5));
  }
}

}  // namespace ensonify
