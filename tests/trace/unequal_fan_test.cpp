// The rays of beams that are not equally spaced: where they go, and what energy they stand for.
#include <algorithm>
#include <cmath>
#include <vector>

#include "catch.h"
#include "core/units.h"
#include "trace/piece_echoes.h"
#include "trace/line_pieces.h"
#include "trace/surface_fixture.h"
#include "trace/volume.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// Seven beams from -12 to 22 degrees in cells of 2 to 11 degrees.
Sonar unequal_sonar(int rays_azimuth, int rays_elevation) {
  Sonar sonar = fan_sonar(7, radians(30), 20, rays_elevation);
  sonar.rays_azimuth = rays_azimuth;
  for (const double azimuth : {-12, -10, -7, -3, 5, 11, 22}) {
    sonar.azimuth_rad.push_back(radians(azimuth));
  }
  const std::vector<double> borders = beam_borders_rad(sonar);
  sonar.beam_spacing_rad = (borders.back() - borders.front()) / 7;
  return sonar;
}

double energy(const Scatterer& s) {
  return std::pow(static_cast<double>(s.standard_deviation) * s.gain, 2);
}

}  // namespace

TEST_CASE("beam cells fill the fan between its borders") {
  const Sonar sonar = unequal_sonar(1, 1);
  const std::vector<double> borders = beam_borders_rad(sonar);
  for (int j = 0; j < 7; ++j) {
    CHECK(cell_width_rad(sonar, j) == Approx(borders[j + 1] - borders[j]));
  }
  CHECK(narrowest_cell_rad(sonar) == Approx(radians(2)));
  CHECK(furthest_azimuth_rad(sonar) == Approx(radians(27.5)));
  Sonar mirrored = sonar;
  std::reverse(mirrored.azimuth_rad.begin(), mirrored.azimuth_rad.end());
  for (double& azimuth : mirrored.azimuth_rad) azimuth = -azimuth;
  CHECK(furthest_azimuth_rad(mirrored) == Approx(radians(27.5)));
  const Sonar equal = fan_sonar(7, radians(30), 20, 1);
  CHECK(cell_width_rad(equal, 3) == equal.beam_spacing_rad);
  CHECK(narrowest_cell_rad(equal) == equal.beam_spacing_rad);
  CHECK(furthest_azimuth_rad(equal) == Approx(radians(15)));
}

TEST_CASE("the rays of a beam are uniform between the borders of its cell") {
  const Sonar sonar = unequal_sonar(4, 3);
  const Fan fan = make_fan(sonar);
  const std::vector<double> borders = beam_borders_rad(sonar);
  for (int j = 0; j < 7; ++j) {
    const double width = borders[j + 1] - borders[j];
    for (int a = 0; a < 4; ++a) {
      const double azimuth = fan.azimuth_rad[j * 4 + a];
      CHECK(azimuth == Approx(borders[j] + (a + 0.5) / 4 * width).margin(1e-12));
      CHECK(sector_of(sonar, azimuth) == j);
    }
  }
}

TEST_CASE("the cells of an unequal fan have the solid angle of the whole fan") {
  const Sonar sonar = unequal_sonar(3, 5);
  const Fan fan = make_fan(sonar);
  double sum = 0;
  for (int j = 0; j < 7; ++j) {
    for (int e = 0; e < 5; ++e) sum += 3 * fan.cell_sr(j, e);
  }
  CHECK(sum == Approx(radians(40.5) * 2 * std::sin(sonar.elevation_fan_rad / 2)).epsilon(1e-12));
}

TEST_CASE("a table of equal azimuths gives the fan of equal beams") {
  const Sonar equal = fan_sonar(12, radians(30), 20, 5);
  Sonar table = equal;
  table.azimuth_rad = beam_azimuths_rad(equal);
  const Fan a = make_fan(equal), b = make_fan(table);
  REQUIRE(a.azimuth_rad.size() == b.azimuth_rad.size());
  for (std::size_t i = 0; i < a.azimuth_rad.size(); ++i) {
    CHECK(b.azimuth_rad[i] == Approx(a.azimuth_rad[i]).margin(1e-14));
  }
  for (int j = 0; j < 12; ++j) CHECK(b.cell_sr(j, 2) == Approx(a.cell_sr(j, 2)).epsilon(1e-12));
}

// The sonar in the middle of a sphere, which every ray meets at the same range and at normal
// incidence: the energy of a beam cell is its width times one number,
//   mu R^2 loss^2 integral B_el^2 dOmega
// which the rays' rows give here as a sum over elevations alone. Adaptive refinement keeps it.
TEST_CASE("a sphere around the sonar returns energy by the width of each beam cell") {
  const int per_cell = GENERATE(0, 40);
  Sonar sonar = unequal_sonar(2, 40);
  sonar.rays_per_cell = per_cell;
  WorldObject ball;
  ball.shape = SphereShape{6, true};
  ball.material = diffuse();
  const World world = world_of({ball});
  const Water water{1500, 0};
  const Tracer tracer(world);
  const SurfaceScattering scattering = make_surface_scattering(sonar, water, world);
  const Fan fan = make_fan(sonar);
  const std::vector<Hit> hits = tracer.trace_fan(fan, {}, sonar.range_max_m, Workers(1));
  const ResolutionCell cell = resolution_cell(sonar, water, 900);
  const ScattererList list =
      per_cell == 0
          ? surface_scatterer_list(fan, hits, scattering, Workers(1))
          : adaptive_surface_scatterers(fan, {hits}, cell, tracer, {}, scattering, Workers(1));
  std::vector<double> per_radian(7);
  for (const Scatterer& s : list.items) {
    per_radian[s.beam] += energy(s) / cell_width_rad(sonar, static_cast<int>(s.beam));
  }
  constexpr int kRows = 4000;
  double rows = 0;
  for (int e = 0; e < kRows; ++e) {
    const double elevation = sonar.elevation_fan_rad * ((e + 0.5) / kRows - 0.5);
    rows += std::pow(elevation_pattern(sonar, elevation), 2) * std::cos(elevation);
  }
  rows *= sonar.elevation_fan_rad / kRows;
  const double expected = 1e-3 * std::pow(6.0, 2) * std::pow(6.0, -4) * rows;
  for (int j = 0; j < 7; ++j) {
    CAPTURE(per_cell, j);
    CHECK(per_radian[j] == Approx(expected).epsilon(2e-3));
  }
}

TEST_CASE("a homogeneous volume returns energy by the width of each beam cell") {
  const Sonar sonar = unequal_sonar(2, 20);
  const Fan fan = make_fan(sonar);
  const std::vector<Hit> none(fan.size());
  const Water water{1500, 0};
  const Record record = make_record(sonar, water, 0);
  const std::vector<VolumeEcho> echoes =
      volume_echoes(fan, none, {{1, 1e-6}}, {}, sonar, water, record, Workers(1));
  REQUIRE(echoes.size() == 1);
  const double first = echoes[0].energy[100] / cell_width_rad(sonar, 0);
  REQUIRE(first > 0);
  for (int j = 1; j < 7; ++j) {
    CHECK(echoes[0].energy[j * record.samples + 100] / cell_width_rad(sonar, j) ==
          Approx(first).epsilon(1e-5));
  }
}

// Protects the density of scatterers: a wide cell has fewer rays per angle and is cut more.
TEST_CASE("wide beam cells are cut more often than narrow ones") {
  Sonar sonar = unequal_sonar(1, 40);
  sonar.rays_per_cell = 8;
  const ResolutionCell cell{radians(1), 0.5};
  const Slant slant{0, 2};
  CHECK(scatterers_per_cell(sonar, cell, slant, 2) ==
        Approx(scatterers_per_cell(sonar, cell, slant) / 2));
  const Fan fan = make_fan(sonar);
  WorldObject floor;
  floor.shape = PlaneShape{};
  floor.pose.position_m = {0, 0, -2};
  floor.material = diffuse();
  const World world = world_of({floor});
  const Tracer tracer(world);
  const std::vector<Hit> hits = tracer.trace_fan(fan, {}, sonar.range_max_m, Workers(1));
  const SurfaceScattering scattering = make_surface_scattering(sonar, {1500, 0}, world);
  const std::vector<std::uint16_t> pieces =
      adaptive_pieces(scattering, cell, {fan, hits, {}}, Workers(1));
  std::vector<double> of_beam(7);
  for (std::size_t ray = 0; ray < pieces.size(); ++ray) of_beam[ray / 40] += pieces[ray];
  // Cells of 2 and 11 degrees.
  CHECK(of_beam[6] > 2 * of_beam[0]);
}
