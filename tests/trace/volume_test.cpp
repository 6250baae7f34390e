// V14, as far as the world makes it: the energy that each sector and sample gets from the water.
#include "trace/volume.h"

#include <cmath>
#include <limits>

#include "acoustics/pattern.h"
#include "catch.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "trace/plain_world.h"

using namespace ensonify;

namespace {

Sonar small_sonar() {
  Sonar sonar = test::fan_sonar(9, radians(18), 8, 114);
  sonar.range_min_m = 0.5;
  return sonar;
}

std::vector<VolumeEcho> echoes_of(const Sonar& sonar, std::span<const Hit> hits,
                                  const std::vector<Volume>& volumes) {
  return volume_echoes(make_fan(sonar), hits, volumes, {}, sonar, kWater,
                       make_record(sonar, kWater, 0), Workers(2));
}

// int phi^power B_el^2 cos(phi) dphi over [low, high], by Simpson's rule.
double elevation_integral(double low, double high, int power) {
  const int n = 2000;
  double sum = 0;
  for (int i = 0; i <= n; ++i) {
    const double phi = low + i * (high - low) / n;
    const double b = line_pattern(phi, radians(20));
    const double weight = i == 0 || i == n ? 1 : 2 + 2 * (i % 2);
    sum += weight * std::pow(phi, power) * b * b * std::cos(phi);
  }
  return sum * (high - low) / n / 3;
}

}  // namespace

// s_v dtheta int B_el^2 cos(phi) dphi . r^2 dr . (r^-2 10^(-absorption 2r/20))^2, dr = c/2b; 114
// rays by the rule of middles are good to 1e-4.
TEST_CASE("V14: energy of the water in a sector and a sample") {
  const Sonar sonar = small_sonar();
  const std::vector<Hit> open(make_fan(sonar).size());
  const auto echoes = echoes_of(sonar, open, {{3, 1e-6}, {4, 5e-5}});
  REQUIRE(echoes.size() == 2);
  CHECK(echoes[1].instance == 4);
  const int samples = make_record(sonar, kWater, 0).samples;
  REQUIRE(echoes[0].energy.size() == 9u * samples);
  const double dr = 1500 / (2 * 29.9e3);
  const double beam = radians(2) * elevation_integral(radians(-10), radians(10), 0);
  const double square = elevation_integral(radians(-10), radians(10), 2) /
                        elevation_integral(radians(-10), radians(10), 0);
  for (const int j : {0, 4}) {
    for (int n = 0; n < samples; ++n) {
      const double r = n * dr;
      const std::size_t pixel = std::size_t(j) * samples + n;
      if (r < 0.5) {
        REQUIRE(echoes[0].energy[pixel] == 0);
        continue;
      }
      const double loss = std::pow(10, -0.3 * 2 * r / 20) / (r * r);
      REQUIRE(echoes[0].energy[pixel] ==
              Approx(1e-6 * beam * r * r * dr * loss * loss).epsilon(2e-4));
      REQUIRE(echoes[1].energy[pixel] == Approx(50 * echoes[0].energy[pixel]).epsilon(1e-6));
      REQUIRE(echoes[0].elevation_rad[pixel] == Approx(0).margin(1e-7));
      REQUIRE(echoes[0].elevation_square[pixel] == Approx(square).epsilon(1e-3));
    }
  }
}

// Protects shadows: the water ends at each ray's own surface. A wall that stands below the sonar's
// plane leaves the upper half.
TEST_CASE("water is heard up to the first surface of each ray") {
  const Sonar sonar = small_sonar();
  const Fan fan = make_fan(sonar);
  const World world = world_with(BoxShape{{0.5, 20, 5}, false}, {{4.5, 0, -5}, {}});
  const Tracer tracer(world);
  const auto hits = tracer.trace_fan(fan, {}, sonar.range_max_m, Workers(1));
  const auto with_wall = echoes_of(sonar, hits, {{1, 1e-6}})[0];
  const auto open = echoes_of(sonar, std::vector<Hit>(fan.size()), {{1, 1e-6}})[0];
  const int samples = make_record(sonar, kWater, 0).samples;
  const double upper =
      elevation_integral(0, radians(10), 1) / elevation_integral(0, radians(10), 0);
  for (int n = 20; n < samples; ++n) {
    const double r = sample_range_m(sonar, kWater, n);
    const std::size_t pixel = 4u * samples + n;  // the rays of this beam meet the wall within 1.6 %
    if (r > 4 && r < 4.08) continue;
    const double share = with_wall.energy[pixel] / open.energy[pixel];
    REQUIRE(share == Approx(r < 4 ? 1 : 0.5).epsilon(1e-6));
    REQUIRE(with_wall.elevation_rad[pixel] == Approx(r < 4 ? 0 : upper).epsilon(1e-3).margin(1e-7));
  }
  const std::vector<Hit> wall(fan.size(), Hit{4.0, 1.0f, 1});
  const auto closed = echoes_of(sonar, wall, {{1, 1e-6}})[0];
  for (int n = 20; n < samples; ++n) {
    const bool before = sample_range_m(sonar, kWater, n) <= 4;
    REQUIRE(closed.energy[n] == (before ? open.energy[n] : 0.0f));
  }
}

TEST_CASE("the transmit pattern and several rays in azimuth weigh the water") {
  Sonar sonar = small_sonar();
  const auto open = [&](const Sonar& s) {
    return echoes_of(s, std::vector<Hit>(make_fan(s).size()), {{1, 1e-6}})[0].energy;
  };
  const auto uniform = open(sonar);
  const int samples = make_record(sonar, kWater, 0).samples;
  sonar.rays_azimuth = 3;
  CHECK(open(sonar)[4 * samples + 100] == Approx(uniform[4 * samples + 100]).epsilon(1e-6));
  sonar.rays_azimuth = 1;
  sonar.transmit_width_rad = radians(16);
  const auto narrow = open(sonar);
  CHECK(narrow[4 * samples + 100] == uniform[4 * samples + 100]);
  // Beam 0 lies at -8 degrees, where a pattern of 16 degrees has fallen by 3 dB.
  CHECK(narrow[100] / uniform[100] == Approx(0.5).epsilon(1e-4));
}

// Protects all other rays and sectors from one bad ray.
TEST_CASE("bad rays hear no water") {
  const Sonar sonar = small_sonar();
  const Fan fan = make_fan(sonar);
  std::vector<Hit> hits(fan.size());
  for (int e = 0; e < fan.rays_elevation; ++e) {
    hits[ray_index(fan, 2, 0, e)] = {std::numeric_limits<double>::quiet_NaN(), 1, 1};
    hits[ray_index(fan, 3, 0, e)] = {-1, 1, 1};
  }
  const auto echo = echoes_of(sonar, hits, {{1, 1e-6}})[0];
  const std::size_t samples = echo.energy.size() / 9;
  for (std::size_t i = 0; i < echo.energy.size(); ++i) {
    const std::size_t beam = i / samples, n = i % samples;
    const bool heard = beam != 2 && beam != 3 && sample_range_m(sonar, kWater, int(n)) >= 0.5;
    REQUIRE((echo.energy[i] > 0) == heard);
    REQUIRE(std::isfinite(echo.elevation_rad[i]));
  }
}

// Protects the energies by elevation: over the steps they add up to those of volume_echoes, of
// endless water and of a box that attenuates, and give its mean elevation to half a step.
TEST_CASE("energies of the water by elevation add up to those of its cells") {
  const Sonar sonar = small_sonar();
  const Fan fan = make_fan(sonar);
  const Record record = make_record(sonar, kWater, 0);
  std::vector<Hit> hits(fan.size());
  for (std::size_t i = 0; i < hits.size(); i += 3) hits[i] = {3.0f + float(i % 7), 1.0f, 1};
  Volume box{5, 1e-5, 0.5, DensityBox{{2, 1, 0.3}}, {{4, 0, 0.2}, {}}};
  const double step_rad = radians(0.7), source = source_pressure_pa_m(sonar);
  for (const std::vector<Volume>& volumes :
       {std::vector<Volume>{{3, 1e-6}, {4, 5e-5}}, std::vector<Volume>{{3, 1e-6}, box}}) {
    const auto cells = echoes_of(sonar, hits, volumes);
    const auto steps = volume_elevation_echoes(fan, hits, volumes, {}, sonar, kWater, record,
                                               step_rad, Workers(2));
    for (const VolumeEcho& volume : cells) {
      std::vector<double> energy(volume.energy.size()), elevation(energy.size());
      for (const ElevationEcho& echo : steps) {
        REQUIRE(echo.offset == 0);
        if (echo.instance != volume.instance) continue;
        const std::size_t cell = std::size_t(echo.beam) * record.samples + echo.sample;
        energy[cell] += echo.diffuse_pa2 / (source * source);
        elevation[cell] += echo.diffuse_pa2 / (source * source) * (echo.step + 0.5) * step_rad;
      }
      double heard = 0;
      for (std::size_t i = 0; i < energy.size(); ++i) {
        REQUIRE(energy[i] == Approx(volume.energy[i]).epsilon(1e-5));
        heard += energy[i];
        if (energy[i] == 0) continue;
        REQUIRE(elevation[i] / energy[i] ==
                Approx(volume.elevation_rad[i]).margin(step_rad / 2 + 1e-6));
      }
      CHECK(heard > 0);
    }
  }
}
