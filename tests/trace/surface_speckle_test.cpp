// Speckle of scatterers fixed on surfaces: levels, statistics over space, and from ping to ping.
#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>

#include "catch.h"
#include "surface_fixture.h"
#include "synthesis/backend.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// A scene and what makes series of it.
struct Bench {
  SurfaceScene scene;
  Workers workers{1};
  std::unique_ptr<Backend> backend =
      make_cpu_backend({scene.sonar, scene.water, make_record(scene.sonar, scene.water, 0)});

  PingSeries series(const Pose& pose, std::uint64_t key, bool wants_clean = false) const {
    const ScattererList list = surface_point_list(scene.tiles, scene.tracer, scene.objects, pose,
                                                  scene.scattering, key, workers);
    const PingTask task{&list, {key, 0, 0, 0, 0}, 0, {}, wants_clean};
    PingSeries series;
    backend->synthesize({&task, 1}, {&series, 1}, workers);
    return series;
  }
};

std::uint64_t key_of_seed(std::uint64_t seed) { return stream_key(seed, Stream::speckle, 0); }

constexpr double kRadius_m = 12;

// Beams of 1 deg every quarter of one, so that the steps of the ideal sectors do not matter; a low
// fan, since what is measured lies in azimuth alone. b = 30 kHz puts 2r/c on a sample.
Sonar sphere_sonar() {
  Sonar sonar = narrow_sonar(kRadius_m + 0.5);
  sonar.bandwidth_hz = 30e3;
  sonar.beam_count = 96;
  sonar.beam_spacing_rad = radians(0.25);
  sonar.elevation_fan_rad = radians(0.4);
  return sonar;
}

Bench inside_sphere(std::vector<Pose> poses) {
  return {{world_of({{1, SphereShape{kRadius_m, true}, {}, diffuse()}}), sphere_sonar(),
           std::move(poses)}};
}

Pose sideways(double y_m) { return {{0, y_m, 0}, {}}; }

struct Pixels {
  std::vector<std::complex<double>> a, b;
};

// The pixels at 2r/c of beams 1 deg apart within 10 deg, the turn of phase that the shift gives
// each beam taken out.
void add_pixels(const Bench& bench, double shift_m, std::uint64_t seed, Pixels& pixels) {
  const SurfaceScene& scene = bench.scene;
  const PingSeries a = bench.series(sideways(-shift_m / 2), key_of_seed(seed));
  const PingSeries b = bench.series(sideways(shift_m / 2), key_of_seed(seed));
  const int samples = make_record(scene.sonar, scene.water, 0).samples;
  const int sample = static_cast<int>(std::lround(kRadius_m * 40));
  const double wavenumber = 2 * kPi * scene.sonar.frequency_hz / scene.water.sound_speed_m_s;
  for (int beam = 8; beam < 88; beam += 4) {
    const double turn = 2 * wavenumber * shift_m * std::sin(beam_azimuth_rad(scene.sonar, beam));
    const std::size_t pixel = std::size_t(beam) * samples + sample;
    pixels.a.push_back(std::complex<double>(a.pressure_pa[pixel]));
    pixels.b.push_back(std::complex<double>(b.pressure_pa[pixel]) * std::polar(1.0, -turn));
  }
}

double correlation(const Pixels& pixels) {
  std::complex<double> sum = 0;
  double a2 = 0, b2 = 0;
  for (std::size_t i = 0; i < pixels.a.size(); ++i) {
    sum += pixels.a[i] * std::conj(pixels.b[i]);
    a2 += std::norm(pixels.a[i]);
    b2 += std::norm(pixels.b[i]);
  }
  return std::abs(sum) / std::sqrt(a2 * b2);
}

}  // namespace

// 20 beams x 100 seeds = 2,000 independent cells: a standard error of at most 0.022 at 0, where the
// magnitude of a sum of noise is about that as well, and less elsewhere.
TEST_CASE("V10: a sonar shifted sideways loses coherence as its aperture's overlap", "[figure]") {
  const double length_m = 0.884 * (1500.0 / 900e3) / radians(1);
  CHECK(length_m == Approx(0.0844).epsilon(1e-3));
  for (const double shift_m : {0.005, 0.0106, 0.0211, 0.0317, 0.0422}) {
    const Bench bench = inside_sphere({sideways(-shift_m / 2), sideways(shift_m / 2)});
    Pixels pixels;
    for (std::uint64_t seed = 0; seed < 100; ++seed) add_pixels(bench, shift_m, seed, pixels);
    REQUIRE(pixels.a.size() == 2000);
    INFO(shift_m);
    CHECK(correlation(pixels) == Approx(std::max(0.0, 1 - 2 * shift_m / length_m)).margin(0.05));
  }
}

// Protects pings at one place from being anything but one ping: nothing is drawn anew.
TEST_CASE("V11: a sonar at rest hears the same") {
  const Bench bench = inside_sphere({{}, {}});
  Pixels pixels;
  add_pixels(bench, 0, 3, pixels);
  CHECK(std::abs(correlation(pixels) - 1) < 1e-6);
  CHECK(bench.series({}, 7).pressure_pa == bench.series({}, 7).pressure_pa);
}

// Protects the level: the closed form of V6, which rays are held to as well, by the expected
// power, in which only the places are drawn.
TEST_CASE("V6: scatterers on a sphere are as loud as its rays") {
  Sonar sonar = narrow_sonar(6);
  sonar.bandwidth_hz = 30e3;
  const Bench bench{{world_of({{1, SphereShape{5, true}, {}, diffuse()}}), sonar, {{}}}};
  const SurfaceScene& scene = bench.scene;
  const PingSeries series = bench.series({}, 5, true);
  const int samples = make_record(scene.sonar, scene.water, 0).samples;
  double clean = 0;
  for (int beam = 20; beam < 70; ++beam) {
    clean += series.clean_power_pa2[std::size_t(beam) * samples + 200] / 50;
  }
  CHECK(level_db(clean) == Approx(153.50).margin(0.15));
}

// V4 over space in place of over draws: one ping of a floor, at pixels so far apart that no two
// share a scatterer's main echo, each against its own expected power. 40 beams x 37 ranges.
TEST_CASE("V4: speckle fixed on a surface is exponential over space", "[figure]") {
  Sonar sonar = narrow_sonar(12);
  sonar.beam_width_rad = radians(0.9);
  const Pose down{{}, from_roll_pitch_yaw(0, radians(14), 0)};
  const Bench bench{{world_of({{1, PlaneShape{}, {{0, 0, -1.5}, {}}, diffuse()}}), sonar, {down}}};
  const SurfaceScene& scene = bench.scene;
  const PingSeries series = bench.series(down, 9, true);
  const int samples = make_record(scene.sonar, scene.water, 0).samples;
  std::vector<double> x;
  for (int beam = 5; beam < 85; beam += 2) {
    for (int n = 190; n < 410; n += 6) {
      const std::size_t pixel = std::size_t(beam) * samples + n;
      x.push_back(std::norm(std::complex<double>(series.pressure_pa[pixel])) /
                  double(series.clean_power_pa2[pixel]));
    }
  }
  const double count = double(x.size());
  CHECK(count >= 1400);
  double mean = 0, square = 0;
  for (const double v : x) mean += v / count, square += v * v / count;
  // Of an exponential: the mean's standard error is 1/sqrt(n), that of the contrast sqrt(2/n).
  CHECK(std::abs(mean - 1) < 3 / std::sqrt(count));
  CHECK(std::abs(std::sqrt(square - mean * mean) / mean - 1) < 3 * std::sqrt(2 / count));
  std::ranges::sort(x);
  double distance = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double f = 1 - std::exp(-x[i]);
    distance = std::max({distance, f - double(i) / count, double(i + 1) / count - f});
  }
  CHECK(std::sqrt(count) * distance < 1.82);
}
