#include "app/run_cost.h"

#include <cmath>

#include "app/cost.h"
#include "app/session.h"
#include "labels/cartesian.h"
#include "synthesis/array.h"

namespace ensonify {
namespace {

// Seconds of a core, of the machine of docs/performance.md: what `ensonify bench` prints for the
// case `full`, and for `array`, over how many there are of each.
constexpr double kRaySeconds = 2.5e-7;            // trace, scatterers, speckle, sums
constexpr double kHiddenRaySeconds = 5e-7;        // shadows, amodal masks
constexpr double kSampleSeconds = 1.3e-8;         // series and expected power
constexpr double kPictureSeconds = 6e-8;          // a labelled pixel, encoded
constexpr double kElementRaySeconds = 2.5e-9;     // an echo at an element
constexpr double kElementSampleSeconds = 1.2e-7;  // beams of an element's series
constexpr double kPingSeconds = 2e-3;             // files, whatever is in them
constexpr double kRunSeconds = 0.05;              // worlds, plans, manifests
constexpr double kSurfaceRays = 4;                // scatterers fixed on surfaces, to a ray
constexpr double kRaysByNeed = 2;
constexpr double kBounce = 0.25;  // echoes that came round once more, to a direct one

double ping_seconds(const Session& session) {
  const OutputSelection& output = session.scenario.output.selection;
  const Sonar& sonar = session.sonar;
  double rays = static_cast<double>(sonar.beam_count) * sonar.rays_azimuth * sonar.rays_elevation;
  if (session.scenario.scattering.speckle == SpeckleMode::surface) rays *= kSurfaceRays;
  if (sonar.rays_per_cell > 0) rays *= kRaysByNeed;
  if (const auto& multipath = session.scenario.multipath) rays *= 1 + kBounce * multipath->bounces;
  const double samples = static_cast<double>(sonar.beam_count) * session.record.samples;
  const double series = 1 + static_cast<double>(layer_count(session));
  double seconds = kPingSeconds + rays * kRaySeconds + series * samples * kSampleSeconds;
  if (output.shadow || output.amodal) seconds += rays * kHiddenRaySeconds;
  if (output.polar || output.png) seconds += samples * kPictureSeconds;
  if (output.cartesian) {
    const CartesianGrid grid = cartesian_grid(sonar, session.scenario.output.cartesian_height_px);
    seconds += static_cast<double>(grid.height_px) * grid.width_px * kPictureSeconds;
  }
  if (sonar.array) {
    seconds += sonar.array->elements *
               (rays * kElementRaySeconds + session.record.samples * kElementSampleSeconds);
  }
  return seconds;
}

// What follows from a logarithm somewhere may differ in the last bit between machines.
double three_digits(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2);
  return std::round(value / unit) * unit;
}

}  // namespace

Result<RunCost> run_cost(Scenario scenario) {
  const Result<Session> session = prepare_without_world(std::move(scenario), 0);
  if (!session) return session.error();
  const Sonar& sonar = session->sonar;
  const std::uint64_t rays =
      std::uint64_t(sonar.beam_count) * sonar.rays_azimuth * sonar.rays_elevation;
  const Cost files = estimate_files(*session, rays);
  RunCost cost{files.pings, files.files, files.disk_bytes, 0};
  cost.core_s =
      three_digits(kRunSeconds + static_cast<double>(files.pings) * ping_seconds(*session));
  return cost;
}

}  // namespace ensonify
