#include "ping/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace ensonify {
namespace {

// From x along the axis of view, y left, z up to x right, y down, z along the axis of view: the
// columns of the rotation are -y, -z and x.
constexpr Quat kOptical{0.5, -0.5, 0.5, -0.5};

Pose inverse(const Pose& pose) {
  const Quat back = conjugate(pose.rotation);
  return {rotate(back, -pose.position_m), back};
}

std::optional<double> surface_of(const Scenario& scenario) {
  if (scenario.camera->surface_z_m) return scenario.camera->surface_z_m;
  if (scenario.multipath && scenario.multipath->surface) return scenario.multipath->surface->z_m;
  if (scenario.water.profile) return scenario.water.profile->surface_z_m;
  return std::nullopt;
}

}  // namespace

std::optional<Camera> camera_of(const Scenario& scenario) {
  if (!scenario.camera) return std::nullopt;
  const CameraSpec& spec = *scenario.camera;
  const Pose on_body = compose(pose_of(spec.mount), {{}, kOptical});
  Camera camera{optics_of(spec), compose(inverse(pose_of(scenario.sonar.mount)), on_body),
                spec.range_max_m, spec.samples, spec.light};
  camera.light.surface_z_m = surface_of(scenario);
  if (spec.water) camera.water = water_of(*spec.water);
  return camera;
}

Pose camera_pose(const Session& session, const Camera& camera, std::uint32_t ping) {
  return compose(sonar_pose(session, ping), camera.in_sonar);
}

Status check_camera(const Session& session) {
  const std::optional<Camera> camera = camera_of(session.scenario);
  if (!camera) return {};
  const std::optional<double> surface_z_m = camera->light.surface_z_m;
  for (std::uint32_t ping = 0; surface_z_m && ping < session.ping_times_s.size(); ++ping) {
    const double z_m = camera_pose(session, *camera, ping).position_m.z;
    if (z_m < *surface_z_m) continue;
    return Error{ErrorKind::usage,
                 fmt::format("camera.mount.position_m: at ping {} the camera is at z = {:.4g} m, "
                             "not below the water surface at {:.4g} m; expected a camera in the "
                             "water at every ping",
                             ping, z_m, *surface_z_m)};
  }
  return {};
}

std::vector<std::vector<Rgb>> camera_colors(const Scenario& scenario,
                                            const std::vector<Instance>& instances) {
  const auto color_of = [&](const std::string& name) {
    const auto found = std::ranges::find(scenario.materials, name, &MaterialSpec::name);
    return found == scenario.materials.end() ? MaterialSpec{}.color : found->color;
  };
  std::vector<std::vector<Rgb>> colors(1);
  for (const Instance& instance : instances) {
    std::vector<std::string> materials = {instance.material};
    for (const InstancePart& part : instance.parts) {
      if (std::ranges::find(materials, part.material) == materials.end()) {
        materials.push_back(part.material);
      }
    }
    for (const InstanceGrowth& growth : instance.growth) materials.push_back(growth.material);
    colors.emplace_back();
    for (const std::string& name : materials) colors.back().push_back(color_of(name));
  }
  return colors;
}

}  // namespace ensonify
