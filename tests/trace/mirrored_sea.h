// A world with mirrors at one moment, and the image method for a target in it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "acoustics/pattern.h"
#include "catch.h"
#include "core/units.h"
#include "scenario/scenario.h"
#include "trace/multipath.h"
#include "trace/scene.h"

namespace ensonify::test {

inline constexpr double kSpeed = 1500, kAbsorption = 0.1;

inline std::string head(double fan_deg, int rays = 4, double fov_deg = 90) {
  return fmt::format(R"(ensonify: 1
sonar:
  frequency_hz: 3e5
  bandwidth_hz: 3e4
  source_level_db: 200
  range_max_m: 100
  beams: {{count: 30, fov_deg: {}, receive_width_deg: 3, transmit_width_deg: 120}}
  elevation: {{width_deg: 60, fan_deg: {}}}
  rays: {{elevation: {}}}
water: {{sound_speed_m_s: {}, absorption: {{fixed_db_m: {}}}}}
)",
                     fov_deg, fan_deg, rays, kSpeed, kAbsorption);
}
inline const std::string kMaterials = R"(materials:
  sand: {reflectivity: 1e-2}
  mirror: {reflectivity: 0, coherent: {model: kirchhoff, reflection: 0.8, roughness_rms_m: 1e-4}}
)";

// A world at one moment, and what is heard of it over mirrors.
struct Sea {
  explicit Sea(const std::string& text) {
    auto parsed = parse_scenario(text, "sea.yaml", ".");
    if (!parsed) FAIL(parsed.error().message);
    scenario = std::move(*parsed);
    auto built = build_world(scenario);
    if (!built) FAIL(built.error().message);
    world = std::make_unique<World>(std::move(*built));
    tracer = std::make_unique<Tracer>(*world);
    sonar = sonar_of(scenario);
    water = {kSpeed, kAbsorption};
    fan = make_fan(sonar);
    scattering = make_surface_scattering(sonar, water, *world);
    auto made = make_bounce_plan(scenario.multipath, flat_reflectors(scenario));
    if (!made) FAIL(made.error().message);
    plan = std::move(*made);
    poses = own_poses(*world);
  }
  std::vector<Hit> hits() const { return tracer->trace_fan(fan, {}, 100, Workers(1)); }
  std::vector<Scatterer> bounced(int threads = 1) const {
    return bounced_echoes({plan, *world, *tracer, poses, {}, scattering}, fan, hits(),
                          Workers(threads));
  }
  std::vector<Scatterer> of_path(std::uint16_t path) const {
    std::vector<Scatterer> found = bounced();
    std::erase_if(found, [&](const Scatterer& s) { return s.path != path; });
    return found;
  }

  Scenario scenario;
  std::unique_ptr<World> world;
  std::unique_ptr<Tracer> tracer;
  Sonar sonar;
  Water water;
  Fan fan;
  SurfaceScattering scattering;
  BouncePlan plan;
  std::vector<Pose> poses;
};

inline std::string target_at(double x, double y, double z) {
  return fmt::format(
      "point_targets: [{{name: p, target_strength_db: -20, position_m: [{}, {}, {}]}}]\n", x, y, z);
}

inline double azimuth(Vec3 p) { return std::atan2(p.y, p.x); }
inline double elevation(Vec3 p) { return std::asin(p.z / length(p)); }
inline double elevation_pattern(const Sonar& sonar, Vec3 p) {
  return line_pattern(elevation(p), sonar.elevation_width_rad);
}

// The pressure of a target of -20 dB over two images of it, without reflections.
inline double target_pressure(const Sonar& sonar, Vec3 out, Vec3 back) {
  const double r_out = length(out), r_back = length(back);
  return 0.1 * std::pow(10, -kAbsorption * (r_out + r_back) / 20) / (r_out * r_back) *
         std::sqrt(elevation_pattern(sonar, out) * elevation_pattern(sonar, back)) *
         transmit_pattern(azimuth(out), sonar.transmit_width_rad);
}

inline double pressure(const Scatterer& s) { return double{s.gain} * double{s.mean.real()}; }

}  // namespace ensonify::test
