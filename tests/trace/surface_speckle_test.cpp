// Speckle of scatterers fixed on surfaces: levels and statistics over space. tests/verification/coherence.py
// has what a shift of the sonar leaves of it, V10 and V11.
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

}  // namespace

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
