#include "ping/scene_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <utility>
#include <variant>

#include "core/units.h"
#include "ping/camera.h"
#include "ping/key_warnings.h"
#include "ping/navigation_files.h"
#include "world/convex.h"
#include "world/ground.h"
#include "world/shapes.h"

namespace ensonify {
namespace {

// Ships are longer than 30 m, and things in millimeters mostly than 100.
constexpr double kLargeM = 100, kSmallM = 0.01;

double longest(Vec3 size) { return std::max({size.x, size.y, size.z}); }

std::string size_text(Vec3 size) {
  return fmt::format("{:.3g} x {:.3g} x {:.3g} m", size.x, size.y, size.z);
}

// glTF and DAE files state their unit of length.
bool has_unit(const MeshSpec& spec) {
  std::string ending = spec.file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".gltf" || ending == ".glb" || ending == ".dae";
}

const Instance& instance_of(const World& world, const WorldObject& object) {
  return world.instances[object.instance - 1];
}

void warn_of_sizes(const Session& session, std::vector<std::string>& warnings) {
  std::set<std::string> told;  // files with a warning already
  for (const ObjectSpec& spec : session.scenario.objects) {
    const auto* mesh = std::get_if<MeshSpec>(&spec.shape);
    if (mesh == nullptr || mesh->scale != MeshSpec{}.scale || has_unit(*mesh)) continue;
    const auto& instances = session.world.instances;
    const auto instance = std::find_if(instances.begin(), instances.end(),
                                       [&](const Instance& of) { return of.name == spec.name; });
    if (instance == instances.end() || !instance->box) continue;
    const Vec3 size = instance->box->size_m;
    if (longest(size) <= kLargeM && longest(size) >= kSmallM) continue;
    if (!told.insert(mesh->file.string()).second) continue;
    std::string advice = "its unit may not be the meter";
    if (const auto scale = likely_scale(longest(size))) {
      advice += fmt::format(": scale: {:g} makes {}", *scale, size_text(*scale * size));
    }
    warnings.push_back(fmt::format("{}: the mesh is {}; {}", spec.name, size_text(size), advice));
  }
}

// How often the surface winds around the point: 1 inside a closed mesh whose faces point outward, 0
// outside of it.
double winding_number(const Mesh& mesh, Vec3 point) {
  double sum_sr = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto& v = mesh.vertices;
    sum_sr += solid_angle_sr({to_vec3(v[a]), to_vec3(v[b]), to_vec3(v[c])}, point);
  }
  return sum_sr / (4 * kPi);
}

bool is_below(const Shape& terrain, const Pose& pose, Vec3 point) {
  const auto surface = ground_at(terrain, pose, point.x, point.y);
  return surface && point.z < surface->height_m;
}

bool is_solid_at(const WorldObject& object, const Pose& pose, Vec3 point) {
  const Vec3 own = rotate(conjugate(pose.rotation), point - pose.position_m);
  return std::visit(
      [&](const auto& shape) {
        if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, MeshShape>) {
          if (shape.ground) return is_below(object.shape, pose, point);
          return winding_number(*shape.mesh, own) > 0.5;
        } else {
          // A plane is visible from both sides, like a water surface.
          const bool is_plane = std::is_same_v<std::decay_t<decltype(shape)>, PlaneShape>;
          return !is_plane && signed_distance_m(shape, own) < 0;
        }
      },
      object.shape);
}

std::string place_text(const Shape& shape) {
  const auto* mesh = std::get_if<MeshShape>(&shape);
  if (mesh != nullptr && mesh->ground) return "below";
  return is_room(shape) ? "outside the room" : "inside";
}

// `place_m` of an instrument at a ping.
void warn_of_solids(const Session& session, const char* instrument,
                    const std::function<Vec3(std::uint32_t)>& place_m,
                    std::vector<std::string>& warnings) {
  const auto last = static_cast<std::uint32_t>(session.ping_times_s.size() - 1);
  std::set<std::uint32_t> told;  // instances with a warning already
  for (const std::uint32_t ping : std::set{0u, last / 2, last}) {
    const Vec3 at = place_m(ping);
    const std::vector<Pose> poses = object_poses(session, ping);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const WorldObject& object = session.world.objects[i];
      if (!is_solid_at(object, poses[i], at) || !told.insert(object.instance).second) continue;
      warnings.push_back(fmt::format("ping {}: the {} at ({:.3g}, {:.3g}, {:.3g}) m is {} {}", ping,
                                     instrument, at.x, at.y, at.z, place_text(object.shape),
                                     instance_of(session.world, object).name));
    }
  }
}

// Poses that interpolation leaves equal, to a millimeter and a tenth of a degree.
bool same_place(const Pose& a, const Pose& b) {
  constexpr double kSameM = 1e-3, kSameCosine = 1 - 1.5e-6;
  const auto axis = [](const Pose& pose, Vec3 along) { return rotate(pose.rotation, along); };
  return length(a.position_m - b.position_m) <= kSameM &&
         dot(axis(a, {1, 0, 0}), axis(b, {1, 0, 0})) >= kSameCosine &&
         dot(axis(a, {0, 1, 0}), axis(b, {0, 1, 0})) >= kSameCosine;
}

// Whether the object stays where it is in the sonar's frame.
bool moves_with_sonar(const Session& session, const WorldObject& object) {
  const auto last = static_cast<std::uint32_t>(session.ping_times_s.size() - 1);
  const auto in_sonar = [&](std::uint32_t ping) {
    return pose_in(sonar_pose(session, ping), object_pose(object, session.ping_times_s[ping]));
  };
  return same_place(in_sonar(0), in_sonar(last / 2)) && same_place(in_sonar(0), in_sonar(last));
}

// Rooms and ground carry nothing.
bool is_body(const WorldObject& object) {
  const auto* mesh = std::get_if<MeshShape>(&object.shape);
  return !is_room(object.shape) && (mesh == nullptr || !mesh->ground);
}

// Objects of equal place and size, to a millimeter.
void warn_of_coincidence(const Session& session, std::vector<std::string>& warnings) {
  constexpr double kSameM = 1e-3;
  const auto rounded = [](Vec3 v) {
    return std::array<std::int64_t, 3>{std::llround(v.x / kSameM), std::llround(v.y / kSameM),
                                       std::llround(v.z / kSameM)};
  };
  std::map<std::array<std::array<std::int64_t, 3>, 2>, std::string> seen;
  std::size_t more = 0;
  for (const WorldObject& object : session.world.objects) {
    const Instance& instance = instance_of(session.world, object);
    if (!instance.box || object.path) continue;
    const auto [at, is_new] =
        seen.try_emplace({rounded(compose(object.pose, instance.box->pose).position_m),
                          rounded(instance.box->size_m)},
                         instance.name);
    if (is_new) continue;
    if (more++ > 0) continue;
    warnings.push_back(
        fmt::format("{} and {} have the same place and the same size", at->second, instance.name));
  }
  if (more > 1) warnings.back() += fmt::format(", and so do {} more", more - 1);
  if (more > 0) warnings.back() += "; copies of an entry need a sampled position or a place";
}

}  // namespace

Status check_mount(const Session& session) {
  const InstrumentKind kind = instrument_kind(session.scenario);
  if (session.scenario.rig.empty() || kind == InstrumentKind::navigation) return {};
  const Vec3 place_m = sonar_pose(session, 0).position_m;
  for (const WorldObject& object : session.world.objects) {
    if (!is_body(object) || !moves_with_sonar(session, object)) continue;
    if (!is_solid_at(object, object_pose(object, session.ping_times_s[0]), place_m)) continue;
    return Error{
        ErrorKind::usage,
        fmt::format("{0}.mount: the {0} is at ({1:.3g}, {2:.3g}, {3:.3g}) m inside {4}, which "
                    "moves with it; expected a mount outside of the body (a tank is a box with "
                    "inside: true, or a mesh whose faces point inward)",
                    name_of(kind), place_m.x, place_m.y, place_m.z,
                    instance_of(session.world, object).name)};
  }
  return {};
}

std::optional<double> likely_scale(double longest_edge_m) {
  if (longest_edge_m <= kLargeM && longest_edge_m >= kSmallM) return std::nullopt;
  const double scale = longest_edge_m > kLargeM ? 1e-3 : 1e3;
  const double edge = scale * longest_edge_m;
  return edge >= 0.05 && edge <= kLargeM ? std::optional(scale) : std::nullopt;
}

namespace {

// No source and receiver have such a large dynamic range together.
constexpr double kMostAbsorptionDb = 250;

void warn_of_range(const Session& session, std::vector<std::string>& warnings) {
  const double two_way_db_m = 2 * session.water.absorption_db_m;
  const double lost_db = two_way_db_m * session.sonar.range_max_m;
  if (lost_db <= kMostAbsorptionDb) return;
  warnings.push_back(
      fmt::format("sonar.range_max_m: absorption alone costs {:.3g} dB on the path to {:g} m and "
                  "back, so there are no echoes from beyond {:.2g} m; the range is in meters",
                  lost_db, session.sonar.range_max_m, kMostAbsorptionDb / two_way_db_m));
}

constexpr double kMostMissing = 0.01;  // share of a target's energy over the band

void warn_of_ringing(const Session& session, std::vector<std::string>& warnings) {
  const auto warn = [&](std::uint32_t instance, const Ringing& ringing) {
    if (ringing.missing <= kMostMissing) return;
    warnings.push_back(fmt::format(
        "{}: the body has so many resonances in the sonar's band that its {} echoes miss {:.2g} "
        "% of the energy",
        session.world.instances[instance - 1].name, ringing.taps.size(), 100 * ringing.missing));
  };
  for (const WorldObject& object : session.world.objects) warn(object.instance, object.ringing);
  for (const PointTarget& target : session.world.point_targets) {
    warn(target.instance, target.ringing);
  }
}

bool may_have_edges(const Shape& shape) {
  if (const auto* box = std::get_if<BoxShape>(&shape)) return !box->inside;
  if (const auto* mesh = std::get_if<MeshShape>(&shape)) return !mesh->ground;
  return std::holds_alternative<CylinderShape>(shape);
}

// Edges that no object of the material has.
void warn_of_edges(const Session& session, std::vector<std::string>& warnings) {
  std::map<std::string, bool> found;  // by material
  for (const WorldObject& object : session.world.objects) {
    if (!object.material.edges) continue;
    found[instance_of(session.world, object).material] |= may_have_edges(object.shape);
  }
  for (const auto& [material, has] : found) {
    if (has) continue;
    warnings.push_back(fmt::format(
        "{}: coherent.edges has no effect, because no object of this material is a box, a cylinder "
        "or a mesh",
        material));
  }
}

}  // namespace

bool is_empty_scene(const Session& session) {
  const World& world = session.world;
  return !session.scenario.has_draws && world.objects.empty() && world.point_targets.empty() &&
         world.volumes.empty() && world.schools.empty();
}

std::vector<std::string> scene_warnings(const Session& session) {
  std::vector<std::string> warnings;
  if (is_empty_scene(session)) {
    warnings.push_back(
        "objects: the scene has no object, point target or volume, so no ping has an echo");
  }
  const bool hears = is_sonar(session.scenario);
  if (hears) warn_of_range(session, warnings);
  warn_of_sizes(session, warnings);
  if (hears) {
    warn_of_solids(
        session, "sonar", [&](std::uint32_t ping) { return sonar_pose(session, ping).position_m; },
        warnings);
  }
  if (const std::optional<Camera> camera = camera_of(session.scenario)) {
    warn_of_solids(
        session, "camera",
        [&](std::uint32_t ping) { return camera_pose(session, *camera, ping).position_m; },
        warnings);
  }
  warn_of_coincidence(session, warnings);
  if (!hears) return warnings;
  warn_of_ringing(session, warnings);
  warn_of_edges(session, warnings);
  for (auto& text : key_warnings(session)) warnings.push_back(std::move(text));
  return warnings;
}

namespace {

constexpr double kShare = 0.05;

std::string gap_text(const Session& session, double share, const std::string& begin,
                     const std::string& advice) {
  return fmt::format(
      "ping 0: {}{:.0f} % of the surface in range has more than {:.2g} m (two samples) of range "
      "between rays, so gaps and rings may be visible; {}",
      begin, 100 * share, session.cell.gap_m, advice);
}

}  // namespace

std::vector<std::string> gap_warnings(const Session& session, const Tracer& tracer,
                                      const Workers& workers) {
  const Fan fan = make_fan(session.sonar);
  const Pose pose = sonar_pose(session, 0);
  const std::vector<Hit> hits = trace_fan(tracer.at(object_poses(session, 0)), fan, pose,
                                          session.sonar, session.water, workers)
                                    .hits;
  const SurfaceScattering scattering =
      make_surface_scattering(session.sonar, session.water, session.world);
  const FanMet met{fan, hits, pose};
  std::vector<std::string> warnings;
  const bool refined = session.sonar.rays_per_cell != 0;
  // Scatterers fixed on surfaces are dense enough by themselves.
  double share = 0;
  if (!session.surface_tiles) {
    const auto pieces = refined ? adaptive_pieces(scattering, session.cell, met, workers)
                                : std::vector<std::uint16_t>();
    share = gapped_share(scattering, session.cell, met, pieces);
  }
  if (share > kShare) {
    warnings.push_back(
        gap_text(session, share, "",
                 refined ? "raise sonar.rays.elevation or leave out "
                           "sonar.rays.min_per_cell"
                         : "sonar.rays.min_per_cell: 20 adds rays where they are needed"));
  }
  if (session.bounces.paths.empty() || (!refined && !session.surface_tiles)) return warnings;
  const double bounced = gapped_share(scattering, session.cell, met);
  if (bounced > kShare) {
    warnings.push_back(gap_text(
        session, bounced, "specular and multipath echoes use only the rays of the fan, with which ",
        "raise sonar.rays.elevation"));
  }
  return warnings;
}

std::vector<std::string> all_warnings(const Session& session, const Tracer& tracer,
                                      const Workers& workers) {
  std::vector<std::string> warnings = session.world.warnings;
  for (auto& text : scene_warnings(session)) warnings.push_back(std::move(text));
  if (is_sonar(session.scenario)) {
    for (auto& text : gap_warnings(session, tracer, workers)) warnings.push_back(std::move(text));
  }
  for (auto& text : navigation_warnings(session, tracer)) warnings.push_back(std::move(text));
  return warnings;
}

}  // namespace ensonify
