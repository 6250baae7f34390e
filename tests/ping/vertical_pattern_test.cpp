// What the vertical pattern of a preset makes of a seabed.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "catch.h"
#include "core/units.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr double kDepth_m = 2;
constexpr double kTilt_deg = 30;

// A level bed below a sonar of five beams that looks down on it.
std::string bed_under(const std::string& sonar) {
  return "ensonify: 1\nsonar: {" + sonar + ", range_max_m: 9, " +
         "beams: {count: 5, fov_deg: 5}, mount: {rotation_deg: [0, 30, 0]}}\n"
         "materials: {sand: {reflectivity: 1e-3}}\n"
         "objects: [{name: bed, material: sand, shape: {plane: {}}, pose: {position_m: [0, 0, "
         "-2]}}]\n"
         "trajectory: {pings: 1}\n";
}

// The sample at which the middle beam meets the bed under an elevation.
int sample_at(const Session& session, double elevation_deg) {
  const double range = kDepth_m / std::sin(radians(kTilt_deg - elevation_deg));
  return static_cast<int>(std::lround(range / sample_range_m(session.sonar, session.water, 1)));
}

// The expected level of the middle beam, dB, by sample.
std::vector<double> middle_beam_db(const SceneRun& run) {
  const PingResult ping = run.ping(0);
  std::vector<double> level;
  for (int n = 0; n < ping.polar->rows; ++n) {
    level.push_back(ping.polar->clean_db[std::size_t(n) * ping.polar->columns + 2]);
  }
  return level;
}

double largest_step_db(const std::vector<double>& level, int first, int last) {
  double largest = 0;
  for (int n = first; n < last; ++n) {
    largest = std::max(largest, std::abs(level[n + 1] - level[n]));
  }
  return largest;
}

}  // namespace

// Protects the picture of a seabed: it fades in under the beam where it once began at an edge, at
// half a width of 20 degrees. With the fan of before there is the edge.
TEST_CASE("a seabed fades in under a preset's beam") {
  const SceneRun wide = SceneRun::of_text(bed_under("preset: blueview_p900_90"));
  const SceneRun cut = SceneRun::of_text(
      bed_under("preset: blueview_p900_90, elevation: {shading: uniform, fan_deg: 20}"));
  const int edge = sample_at(wide.session(), -10);
  const std::vector<double> faded = middle_beam_db(wide), knife = middle_beam_db(cut);
  CHECK(largest_step_db(faded, edge - 20, edge + 20) < 1);
  CHECK(largest_step_db(knife, edge - 20, edge + 20) > 6);
  const double peak = *std::max_element(faded.begin(), faded.end());
  const int start = sample_at(wide.session(), -28);
  CHECK(faded[start] < peak - 25);
  // No black ring on the way up: over four samples the level only rises.
  for (int n = start; n < edge - 4; ++n) {
    INFO("sample " << n);
    CHECK(faded[n + 4] > faded[n]);
  }
}

// Protects all presets of products from an edge and from a black ring: within the fan there is the
// main lobe alone, and it falls to nothing at its ends.
TEST_CASE("the fan of a preset ends at the first zero of its pattern") {
  int presets = 0;
  for (const SonarPreset& preset : sonar_presets()) {
    if (preset.name == "paper_table1") continue;
    INFO(preset.name);
    const SceneRun run = SceneRun::of_text("ensonify: 1\nsonar: {preset: " + preset.name +
                                           ", beams: {count: 24, fov_deg: 24}}\n");
    const Sonar& sonar = run.session().sonar;
    const double end = sonar.elevation_fan_rad / 2;
    CHECK(std::abs(elevation_pattern(sonar, end)) < 0.003);
    double before = 1;
    for (int i = 1; i < 40; ++i) {
      const double here = elevation_pattern(sonar, i * end / 40);
      CHECK(here > 0);
      CHECK(here < before);
      before = here;
    }
    ++presets;
  }
  CHECK(presets >= 16);
}

// Protects the way back to the echoes of before: with these keys a preset has the rays, the pattern
// and the amplitudes of the line without weights, and a written-out sonar the same to the bit.
TEST_CASE("a preset without shading and rays by need has the echoes of the plain line") {
  const SceneRun plain = SceneRun::of_text(
      bed_under("preset: blueview_p900_90, elevation: {shading: uniform, fan_deg: 20}, "
                "rays: {elevation: 114, min_per_cell: 0}"));
  const SceneRun written = SceneRun::of_text(
      "ensonify: 1\nsonar: {frequency_hz: 900000, bandwidth_hz: 29900, source_level_db: 220, "
      "range_min_m: 0.5, range_max_m: 9, beams: {count: 5, fov_deg: 5, receive_width_deg: 1}, "
      "elevation: {width_deg: 20}, rays: {elevation: 114, azimuth: 1, min_per_cell: 0}, "
      "mount: {rotation_deg: [0, 30, 0]}}\n"
      "materials: {sand: {reflectivity: 1e-3}}\n"
      "objects: [{name: bed, material: sand, shape: {plane: {}}, pose: {position_m: [0, 0, -2]}}]\n"
      "trajectory: {pings: 1}\n");
  const PingResult a = plain.ping(0), b = written.ping(0);
  CHECK(a.series == b.series);
  CHECK(a.polar->clean_db == b.polar->clean_db);
  REQUIRE(a.scatterers.size() > 5 * 50);
  const double absorption = plain.session().water.absorption_db_m;
  for (const Scatterer& s : a.scatterers.items) {
    // The direction is kept in single precision.
    const double range = s.delay_s * plain.session().water.sound_speed_m_s / 2;
    const double pattern = line_pattern(s.arrival.elevation_rad, radians(20));
    CHECK(s.gain == Approx(two_way_loss(range, absorption) * pattern).epsilon(1e-5));
  }
}
