// Made-up sand through the whole chain: what is asked of the ripples is found in the image.
#include <cmath>
#include <complex>
#include <tuple>

#include "catch.h"
#include "core/units.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr double kHeight_m = 2.5;  // of the sonar above the mean seabed
constexpr double kTilt_rad = 25 * kPi / 180;

struct GroundPixel {
  double x_m, y_m;
  double level_db;  // above the mean of its range
};

// Where the flat seabed lies in beam `azimuth` at a range: -sin(tilt) cos(azimuth) cos(e) +
// cos(tilt) sin(e) = -height / range for the elevation e.
std::pair<double, double> ground_point(double range_m, double azimuth_rad) {
  const double a = std::sin(kTilt_rad) * std::cos(azimuth_rad), b = std::cos(kTilt_rad);
  const double elevation = std::atan2(a, b) - std::asin(kHeight_m / range_m / std::hypot(a, b));
  const double y = range_m * std::cos(elevation) * std::sin(azimuth_rad);
  return {std::sqrt(range_m * range_m - kHeight_m * kHeight_m - y * y), y};
}

// The seabed's own pixels of the clean polar image from 4 m on, every second range.
std::vector<GroundPixel> ground_pixels(const SceneRun& run, const LabelledImage& polar) {
  const Sonar& sonar = run.session().sonar;
  std::vector<GroundPixel> pixels;
  for (int n = 0; n < polar.rows; n += 2) {
    const double range = sample_range_m(sonar, run.session().water, n);
    if (range < 4) continue;
    const std::size_t first = pixels.size();
    double sum_db = 0;
    for (int j = 0; j < polar.columns; ++j) {
      const std::size_t at = std::size_t(n) * polar.columns + j;
      if (polar.instance[at] != 1) continue;
      const auto [x, y] = ground_point(range, beam_azimuth_rad(sonar, j));
      pixels.push_back({x, y, polar.clean_db[at]});
      sum_db += polar.clean_db[at];
    }
    const double mean_db = sum_db / static_cast<double>(pixels.size() - first);
    for (std::size_t i = first; i < pixels.size(); ++i) pixels[i].level_db -= mean_db;
  }
  return pixels;
}

double response(const std::vector<GroundPixel>& pixels, double wavelength_m, double direction_deg) {
  const double k = 2 * kPi / wavelength_m;
  const double kx = k * std::cos(radians(direction_deg)), ky = k * std::sin(radians(direction_deg));
  std::complex<double> sum;
  for (const GroundPixel& p : pixels) sum += std::polar(p.level_db, -kx * p.x_m - ky * p.y_m);
  return std::abs(sum) / static_cast<double>(pixels.size());
}

}  // namespace

// Protects the whole way from wavelength and direction in a scenario to the stripes of an image.
TEST_CASE("the image's spectrum shows the ripples' wavelength and direction", "[figure]") {
  const SceneRun run("rippled_seabed", {{"trajectory.poses", "[{position_m: [0, 0, 0]}]"},
                                        {"sonar.beams.count", "128"},
                                        {"sonar.rays.elevation", "256"},
                                        {"output.cartesian", "false"},
                                        {"output.png", "false"}});
  const PingResult ping = run.ping(0);
  const std::vector<GroundPixel> pixels = ground_pixels(run, *ping.polar);
  REQUIRE(pixels.size() > 8000);
  double most = 0, second = 0, wavelength_m = 0, direction_deg = 0;
  for (double w = 0.3; w < 1; w *= 1.02) {
    for (double d = -90; d < 90; d += 5) {
      const double found = response(pixels, w, d);
      const bool near_ripples = std::abs(w / 0.5 - 1) < 0.1 && std::abs(d - 25) < 15;
      if (!near_ripples) second = std::max(second, found);
      if (found > most) std::tie(most, wavelength_m, direction_deg) = std::tuple(found, w, d);
    }
  }
  for (const double w : {0.485, 0.49, 0.495, 0.5, 0.505, 0.51, 0.515}) {
    for (double d = 20; d <= 30; d += 1) {
      const double found = response(pixels, w, d);
      if (found > most) std::tie(most, wavelength_m, direction_deg) = std::tuple(found, w, d);
    }
  }
  INFO("peak " << most << " dB at " << wavelength_m << " m, " << direction_deg
               << " deg; elsewhere at most " << second << " dB");
  CHECK(wavelength_m == Approx(0.5).epsilon(0.015));
  CHECK(direction_deg == Approx(25).margin(2));
  CHECK(most > 3 * second);
}

// Protects reproducibility: terrain, hits and echoes to the last bit, whoever works them out.
TEST_CASE("the series over terrain is the same whatever the threads", "[figure]") {
  const std::vector<Override> small = {{"trajectory.poses", "[{position_m: [0, 0, 0]}]"},
                                       {"sonar.beams.count", "32"},
                                       {"sonar.rays.elevation", "32"},
                                       {"output.cartesian", "false"},
                                       {"output.png", "false"}};
  for (const char* scene : {"rippled_seabed", "stony_seabed"}) {
    const SceneRun one(scene, small), other(scene, small);
    const PingResult a = one.ping(0, 1), b = other.ping(0, 5);
    const bool same_series = a.series == b.series;
    const bool same_levels = a.polar->clean_db == b.polar->clean_db;
    const bool same_masks = a.polar->instance == b.polar->instance;
    CHECK(same_series);
    CHECK(same_levels);
    CHECK(same_masks);
  }
}

// Protects the way from a sediment's reflectivity to the image: a patch that covers everything adds
// its decibels to every pixel of the bed.
TEST_CASE("a patch of sediment changes the level by its reflectivity") {
  const auto run = [](const std::string& patches) {
    return SceneRun("rippled_seabed",
                    {{"objects",
                      "[{name: bed, material: sand, pose: {position_m: [6, 0, -2.5]}, shape: "
                      "{heightfield: {size_m: [28, 24], cell_m: 0.5, patches: [" +
                          patches + "]}}}]"},
                     {"trajectory.poses", "[{position_m: [0, 0, 0]}]"},
                     {"sonar.beams.count", "32"},
                     {"sonar.rays.elevation", "64"},
                     {"output.cartesian", "false"},
                     {"output.png", "false"}});
  };
  const PingResult plain = run("").ping(0);
  const PingResult patched = run("{share: 1, correlation_m: 2, reflectivity_db: -7}").ping(0);
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < plain.polar->clean_db.size(); ++i) {
    if (plain.polar->instance[i] != 1) continue;
    ++pixels;
    CHECK(plain.polar->clean_db[i] - patched.polar->clean_db[i] == Approx(7).margin(1e-3));
  }
  CHECK(pixels > 2000);
}
