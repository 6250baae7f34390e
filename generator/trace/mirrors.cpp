#include "trace/mirrors.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "acoustics/scattering.h"
#include "core/counted.h"

namespace ensonify {
namespace {

// A ray that starts on one reflector must go at least this far to meet the next.
constexpr double kNearest_m = 1e-6;

void add_body(const FlatReflector& body, std::vector<Mirror>& mirrors) {
  Mirror mirror;
  mirror.object = static_cast<int>(body.object);
  mirror.reflection = body.reflection;
  mirror.roughness_rms_m = body.roughness_rms_m;
  if (!body.is_box) {
    mirror.name = body.name + ".z";
    mirrors.push_back(mirror);
    return;
  }
  mirror.bounded = true;
  for (mirror.axis = 0; mirror.axis < 3; ++mirror.axis) {
    for (const double side : {-1.0, 1.0}) {
      mirror.side = side;
      mirror.name = fmt::format("{}.{}{}", body.name, "xyz"[mirror.axis], side < 0 ? '-' : '+');
      mirrors.push_back(mirror);
    }
  }
}

void add_mirrors(const Multipath& multipath, std::span<const FlatReflector> bodies,
                 BouncePlan& plan) {
  const auto add_flat = [&](const std::optional<FlatSurface>& flat, const char* name, double side) {
    if (!flat) return -1;
    Mirror mirror;
    mirror.name = name;
    mirror.z_m = flat->z_m;
    mirror.side = side;
    mirror.reflection = flat->reflection;
    mirror.roughness_rms_m = flat->roughness_rms_m;
    plan.mirrors.push_back(mirror);
    return static_cast<int>(plan.mirrors.size()) - 1;
  };
  plan.surface = add_flat(multipath.surface, "surface", -1);
  plan.bottom = add_flat(multipath.bottom, "bottom", 1);
  if (!multipath.objects) return;
  for (const FlatReflector& body : bodies) add_body(body, plan.mirrors);
}

// Whether sound can travel from one reflector to another.
bool may_follow(std::span<const FlatReflector> bodies, const std::vector<Mirror>& mirrors,
                std::uint16_t from, std::uint16_t to) {
  if (from == to) return false;
  const int object = mirrors[from].object;
  if (object == Mirror::kNoObject || object != mirrors[to].object) return true;
  const auto body =
      std::ranges::find(bodies, static_cast<std::size_t>(object), &FlatReflector::object);
  return body->inside;
}

// Returns false if there are more than kMaxSoundPaths legs.
bool add_legs(int most_bounces, std::span<const FlatReflector> bodies, BouncePlan& plan) {
  plan.legs = {{}};
  std::size_t first = 0;
  for (int bounces = 1; bounces <= most_bounces; ++bounces) {
    const std::size_t last = plan.legs.size();
    for (std::size_t i = first; i < last; ++i) {
      for (std::uint16_t m = 0; m < plan.mirrors.size(); ++m) {
        if (!plan.legs[i].empty() && !may_follow(bodies, plan.mirrors, plan.legs[i].back(), m)) {
          continue;
        }
        Leg longer = plan.legs[i];
        longer.push_back(m);
        plan.legs.push_back(std::move(longer));
        if (plan.legs.size() > kMaxSoundPaths) return false;
      }
    }
    first = last;
  }
  return true;
}

std::vector<std::string> names_of(const BouncePlan& plan, const Leg& leg, bool back) {
  std::vector<std::string> names;
  for (const std::uint16_t m : leg) names.push_back(plan.mirrors[m].name);
  if (back) std::reverse(names.begin(), names.end());
  return names;
}

// Returns false if there are more than kMaxSoundPaths paths. A leg lists its reflectors in order
// from the sonar; returning sound meets them in reverse order.
bool add_paths(std::size_t bounces_max, BouncePlan& plan) {
  std::map<std::pair<std::size_t, std::size_t>, std::uint16_t> id_of;
  for (std::size_t bounces = 1; bounces <= bounces_max; ++bounces) {
    for (std::size_t out = 0; out < plan.legs.size(); ++out) {
      if (plan.legs[out].size() > bounces) break;
      for (std::size_t back = 0; back < plan.legs.size(); ++back) {
        if (plan.legs[out].size() + plan.legs[back].size() != bounces) continue;
        if (plan.paths.size() == kMaxSoundPaths) return false;
        const auto id = static_cast<std::uint16_t>(plan.paths.size() + 1);
        id_of[{out, back}] = id;
        plan.paths.push_back(
            {id, names_of(plan, plan.legs[out], false), names_of(plan, plan.legs[back], true)});
      }
    }
  }
  for (const auto& [legs, id] : id_of) {
    if (legs.first > legs.second) continue;
    plan.pairs.push_back({static_cast<std::uint16_t>(legs.first),
                          static_cast<std::uint16_t>(legs.second), id,
                          id_of.at({legs.second, legs.first})});
  }
  return true;
}

constexpr Vec3 kAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
double component(Vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

PlacedMirror placed(const Mirror& mirror, const World& world, std::span<const Pose> object_in_world,
                    Vec3 sonar_m) {
  PlacedMirror p;
  p.reflection = mirror.reflection;
  p.roughness_rms_m = mirror.roughness_rms_m;
  if (mirror.object == Mirror::kNoObject) {
    p.normal = {0, 0, mirror.side};
    p.offset_m = mirror.side * (mirror.z_m - sonar_m.z);
    p.one_sided = true;
    return p;
  }
  const Pose& pose = object_in_world[mirror.object];
  p.normal = rotate(pose.rotation, mirror.side * kAxes[mirror.axis]);
  p.centre_m = pose.position_m - sonar_m;
  if (mirror.bounded) {
    const auto& box = std::get<BoxShape>(world.objects[mirror.object].shape);
    const int along = (mirror.axis + 1) % 3, across = (mirror.axis + 2) % 3;
    p.centre_m = p.centre_m + component(box.half_size_m, mirror.axis) * p.normal;
    p.along = rotate(pose.rotation, kAxes[along]);
    p.across = rotate(pose.rotation, kAxes[across]);
    p.half_along_m = component(box.half_size_m, along);
    p.half_across_m = component(box.half_size_m, across);
    p.bounded = p.one_sided = true;
    if (box.inside) p.normal = -p.normal;
  }
  p.offset_m = dot(p.normal, p.centre_m);
  return p;
}

bool within_bounds(const PlacedMirror& mirror, Vec3 p) {
  if (!mirror.bounded) return true;
  const Vec3 off = p - mirror.centre_m;
  return std::abs(dot(off, mirror.along)) <= mirror.half_along_m &&
         std::abs(dot(off, mirror.across)) <= mirror.half_across_m;
}

}  // namespace

Result<BouncePlan> make_bounce_plan(const std::optional<Multipath>& multipath,
                                    std::span<const FlatReflector> bodies) {
  BouncePlan plan;
  if (!multipath) return plan;
  add_mirrors(*multipath, bodies, plan);
  if (plan.mirrors.empty()) {
    return Error{ErrorKind::usage,
                 "multipath.objects: no object is a specular reflector; expected a plane or box of "
                 "a kirchhoff material among the objects, or a surface or bottom"};
  }
  if (add_legs(multipath->bounces, bodies, plan) &&
      add_paths(static_cast<std::size_t>(multipath->bounces), plan)) {
    return plan;
  }
  return Error{ErrorKind::usage,
               fmt::format("multipath.bounces: {} and {} give more than {} paths; expected fewer "
                           "bounces, or fewer planes and boxes of kirchhoff materials",
                           counted(plan.mirrors.size(), "specular reflector"),
                           counted(static_cast<std::uint64_t>(multipath->bounces), "bounce"),
                           kMaxSoundPaths)};
}

std::vector<PlacedMirror> place_mirrors(const BouncePlan& plan, const World& world,
                                        std::span<const Pose> object_in_world, Vec3 sonar_m) {
  std::vector<PlacedMirror> mirrors;
  for (const Mirror& mirror : plan.mirrors) {
    mirrors.push_back(placed(mirror, world, object_in_world, sonar_m));
  }
  return mirrors;
}

Vec3 image_seen_over(std::span<const PlacedMirror> mirrors, const Leg& leg, Vec3 point_m) {
  for (std::size_t i = leg.size(); i-- > 0;) {
    const PlacedMirror& m = mirrors[leg[i]];
    point_m = point_m - 2 * (dot(m.normal, point_m) - m.offset_m) * m.normal;
  }
  return point_m;
}

bool walk(std::span<const PlacedMirror> mirrors, const Leg& leg, Vec3 direction,
          double length_max_m, double wavelength_m, Walk& way) {
  way.length_m = 0;
  way.reflection = 1;
  way.direction[0] = direction;
  Vec3 from;
  for (std::size_t i = 0; i < leg.size(); ++i) {
    const PlacedMirror& m = mirrors[leg[i]];
    const double toward = dot(m.normal, direction);
    if (toward == 0 || (m.one_sided && toward > 0)) return false;
    const double piece = (m.offset_m - dot(m.normal, from)) / toward;
    if (!(piece > kNearest_m && way.length_m + piece <= length_max_m)) return false;
    from = from + piece * direction;
    if (!within_bounds(m, from)) return false;
    direction = direction - 2 * toward * m.normal;
    way.at_m[i] = from;
    way.piece_m[i] = piece;
    way.direction[i + 1] = direction;
    way.length_m += piece;
    way.reflection *=
        coherent_reflection(m.reflection, m.roughness_rms_m, wavelength_m, std::abs(toward));
  }
  return true;
}

}  // namespace ensonify
