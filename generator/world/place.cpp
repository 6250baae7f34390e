#include "world/place.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "core/random.h"
#include "core/units.h"
#include "world/ground.h"
#include "world/outline.h"

namespace ensonify {
namespace {

constexpr std::uint32_t kAttempts = 200;

// A cylinder that is taken.
struct Taken {
  std::string name;
  std::string on;  // what it stands on, if it was placed
  double x_m = 0, y_m = 0, radius_m = 0, low_m = 0, high_m = 0;
  double clearance_m = 0;
};

Taken taken_by(const ObjectSpec& spec, const Outline& outline, const Pose& pose) {
  const Vec3 p = pose.position_m;
  Taken taken{spec.name,
              "",
              p.x + outline.x_m,
              p.y + outline.y_m,
              outline.radius_m,
              p.z + outline.low_m,
              p.z + outline.high_m,
              0};
  if (spec.place) {
    taken.on = spec.place->on;
    taken.clearance_m = spec.place->clearance_m;
  }
  return taken;
}

// What a resting object takes; a plane and a room take nothing.
bool takes_room(const Shape& shape) {
  if (const auto* box = std::get_if<BoxShape>(&shape)) return !box->inside;
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return !sphere->inside;
  return !std::holds_alternative<PlaneShape>(shape);
}

bool overlap(const Taken& a, const Taken& b) {
  const double clearance = std::max(a.clearance_m, b.clearance_m);
  const double apart = std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
  if (apart >= a.radius_m + b.radius_m + clearance) return false;
  // On one ground nothing stands over another; elsewhere it may pass above or below.
  if (!a.on.empty() && a.on == b.on) return true;
  return a.low_m < b.high_m + clearance && b.low_m < a.high_m + clearance;
}

// Whether one lies within the circle of the other, seen from above.
bool holds(const Taken& outer, const Taken& inner) {
  return std::hypot(outer.x_m - inner.x_m, outer.y_m - inner.y_m) + inner.radius_m <=
         outer.radius_m;
}

// What an object is placed with.
struct Body {
  const ObjectSpec& spec;
  const Shape& shape;
  std::vector<Vec3> points;  // in its own frame
  const Ground& ground;
  const std::optional<Taken>& ground_taken;  // nothing for a ground without end
};

// The height of the origin at which the turned body, let down over (x, y), touches the ground;
// nothing if some of it is beside the ground.
std::optional<double> resting_height(const Body& body, const Quat& rotation, double x, double y) {
  double height = -std::numeric_limits<double>::infinity();
  Vec3 normal;
  const auto let_down = [&](Vec3 point) {
    const Vec3 p = rotate(rotation, point);
    const auto below = body.ground.at(x + p.x, y + p.y);
    if (below && below->height_m - p.z > height) {
      height = below->height_m - p.z;
      normal = below->normal;
      return std::optional(true);
    }
    return below ? std::optional(false) : std::nullopt;
  };
  for (const Vec3& point : body.points) {
    if (!let_down(point)) return std::nullopt;
  }
  // Round bodies touch between those points, where the surface faces the ground.
  for (int i = 0; i < 4; ++i) {
    const auto point = support_point(body.shape, rotate(conjugate(rotation), -normal));
    if (!point) break;
    const auto touches = let_down(*point);
    if (!touches) return std::nullopt;
    if (!*touches) break;
  }
  return height;
}

// The normal of the plane through the ground under a circle, by least squares.
std::optional<Vec3> slope_under(const Ground& ground, double x, double y, double radius) {
  double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0;
  for (int ring = 1; ring <= 2; ++ring) {
    for (int i = 0; i < 16; ++i) {
      const double angle = 2 * kPi * i / 16;
      const double u = radius * ring / 2 * std::cos(angle), v = radius * ring / 2 * std::sin(angle);
      const auto below = ground.at(x + u, y + v);
      if (!below) return std::nullopt;
      xx += u * u, xy += u * v, yy += v * v;
      xz += u * below->height_m, yz += v * below->height_m;
    }
  }
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > 0)) return Vec3{0, 0, 1};
  return normalized(
      Vec3{-(xz * yy - yz * xy) / determinant, -(yz * xx - xz * xy) / determinant, 1});
}

// The shortest turn of z to a normal that points upwards.
Quat turn_to(Vec3 normal) { return normalized(Quat{1 + normal.z, -normal.y, normal.x, 0}); }

struct Attempt {
  std::optional<Pose> pose;
  const Taken* in_the_way = nullptr;  // neither: no ground
};

Attempt attempt_to_place(const Body& body, const std::vector<Taken>& taken, const Philox4& words) {
  const PlaceSpec& place = *body.spec.place;
  const auto& [from, to] = place.area_m;
  const double x = from[0] + uniform_from_word(words.v[0]) * (to[0] - from[0]);
  const double y = from[1] + uniform_from_word(words.v[1]) * (to[1] - from[1]);
  const double yaw = place.any_yaw ? 2 * kPi * uniform_from_word(words.v[2]) : 0;
  Quat rotation = from_roll_pitch_yaw(0, 0, yaw) * pose_of({{}, place.rotation}).rotation;
  Outline outline = outline_of(body.shape, rotation);
  if (place.along_surface) {
    const auto normal = slope_under(body.ground, x, y, outline.radius_m);
    if (!normal) return {};
    rotation = turn_to(*normal) * rotation;
    outline = outline_of(body.shape, rotation);
  }
  // The cheap question first.
  Taken own = taken_by(body.spec, outline, {{x - outline.x_m, y - outline.y_m, 0}, rotation});
  for (const Taken& other : taken) {
    if (other.on == place.on && overlap(own, other)) return {std::nullopt, &other};
  }
  const double origin_x = x - outline.x_m, origin_y = y - outline.y_m;
  const auto height = resting_height(body, rotation, origin_x, origin_y);
  if (!height) return {};
  const Pose pose{{origin_x, origin_y, *height - place.sink_m}, rotation};
  own = taken_by(body.spec, outline, pose);
  for (const Taken& other : taken) {
    if (other.name == place.on || !overlap(own, other)) continue;
    // What surrounds the ground surrounds all that stands on it.
    if (other.on.empty() && body.ground_taken && holds(other, *body.ground_taken)) continue;
    return {std::nullopt, &other};
  }
  return {pose, nullptr};
}

ErrorKind kind_of(PlaceFailure failure) {
  if (failure == PlaceFailure::redraw) return ErrorKind::redraw;
  return failure == PlaceFailure::error ? ErrorKind::final_usage : ErrorKind::usage;
}

struct Tally {
  std::uint32_t without_ground = 0;
  std::map<std::string, std::uint32_t> in_the_way;
};

Error no_room(std::size_t index, const Body& body, const Tally& tally) {
  std::string most;
  std::uint32_t count = 0, all = 0;
  for (const auto& [name, times] : tally.in_the_way) {
    all += times;
    if (times > count) most = name, count = times;
  }
  std::string why =
      fmt::format("{} times not all of it above {}", tally.without_ground, body.spec.place->on);
  if (all > 0) {
    why += fmt::format(", {} times too near to another object, most often {}", all, most);
  }
  return {kind_of(body.spec.place->on_failure),
          fmt::format("objects.{}.place: no free place for {} in {} draws: {}; accepted is an "
                      "area_m with room for it on {}: make it larger, or clearance_m or the number "
                      "of objects smaller",
                      index, body.spec.name, kAttempts, why, body.spec.place->on)};
}

Error no_ground(std::size_t index, const ObjectSpec& spec) {
  return {kind_of(spec.place->on_failure),
          fmt::format("objects.{}.place: {} was to stand on {}, for which there is no free place",
                      index, spec.name, spec.place->on)};
}

// Grounds and what is taken, while objects are being placed.
class Site {
 public:
  Site(const Scenario& scenario, World& world) : scenario_(scenario) {
    for (WorldObject& object : world.objects) {
      by_name_.emplace(world.instances[object.instance - 1].name, &object);
    }
    for (const ObjectSpec& spec : scenario.objects) {
      if (!spec.place) take(spec);
    }
  }

  Status place(std::size_t index, std::uint64_t key) {
    const ObjectSpec& spec = scenario_.objects[index];
    WorldObject& object = *by_name_.at(spec.name);
    if (left_out_.contains(spec.place->on)) return no_ground(index, spec);
    if (std::holds_alternative<PlaneShape>(object.shape)) {
      return Error{ErrorKind::final_usage,
                   fmt::format("objects.{}.place: {} is a plane without end and cannot be placed, "
                               "accepted is a pose",
                               index, spec.name)};
    }
    const std::optional<Taken> around = around_ground(spec.place->on);
    const Body body{spec, object.shape, contact_points(object.shape), ground(spec.place->on),
                    around};
    Tally tally;
    for (std::uint32_t i = 0; i < kAttempts; ++i) {
      const Attempt attempt =
          attempt_to_place(body, taken_, random_words(key, 0, name_key(spec.name), i));
      if (attempt.pose) {
        object.pose = *attempt.pose;
        take(spec);
        return {};
      }
      if (attempt.in_the_way != nullptr) {
        ++tally.in_the_way[attempt.in_the_way->name];
      } else {
        ++tally.without_ground;
      }
    }
    return no_room(index, body, tally);
  }

  void leave_out(const ObjectSpec& spec) { left_out_.insert(spec.name); }

 private:
  void take(const ObjectSpec& spec) {
    const WorldObject& object = *by_name_.at(spec.name);
    if (!takes_room(object.shape)) return;
    const Outline outline = outline_of(object.shape, object.pose.rotation);
    taken_.push_back(taken_by(spec, outline, object.pose));
  }

  const Ground& ground(const std::string& name) {
    auto& made = grounds_[name];
    const WorldObject& object = *by_name_.at(name);
    if (!made) made = std::make_unique<Ground>(object.shape, object.pose);
    return *made;
  }

  std::optional<Taken> around_ground(const std::string& name) const {
    const auto found = std::find_if(taken_.begin(), taken_.end(),
                                    [&](const Taken& taken) { return taken.name == name; });
    if (found == taken_.end()) return std::nullopt;
    return *found;
  }

  const Scenario& scenario_;
  std::map<std::string, WorldObject*> by_name_;
  std::map<std::string, std::unique_ptr<Ground>> grounds_;
  std::vector<Taken> taken_;
  std::set<std::string> left_out_;
};

// The ids of the others close up.
void remove_left_out(World& world) {
  const auto is_left_out = [&](const std::string& name) {
    return std::find(world.left_out.begin(), world.left_out.end(), name) != world.left_out.end();
  };
  std::erase_if(world.objects, [&](const WorldObject& object) {
    return is_left_out(world.instances[object.instance - 1].name);
  });
  std::vector<std::uint16_t> new_id(world.instances.size() + 1);
  std::uint16_t next = 0;
  for (Instance& instance : world.instances) {
    if (is_left_out(instance.name)) continue;
    new_id[instance.id] = ++next;
    instance.id = next;
  }
  std::erase_if(world.instances,
                [&](const Instance& instance) { return is_left_out(instance.name); });
  for (WorldObject& object : world.objects) object.instance = new_id[object.instance];
}

}  // namespace

Status place_objects(const Scenario& scenario, SequenceDraw draw, World& world) {
  const bool any = std::any_of(scenario.objects.begin(), scenario.objects.end(),
                               [](const ObjectSpec& spec) { return spec.place.has_value(); });
  if (!any) return {};
  const std::uint64_t key = stream_key(scenario.seed, Stream::place, draw);
  Site site(scenario, world);
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const ObjectSpec& spec = scenario.objects[i];
    if (!spec.place) continue;
    Status placed = site.place(i, key);
    if (placed) continue;
    const bool may_go = placed.error().kind != ErrorKind::final_usage;
    if (!may_go || spec.place->on_failure != PlaceFailure::skip_object) return placed;
    site.leave_out(spec);
    world.left_out.push_back(spec.name);
  }
  if (!world.left_out.empty()) remove_left_out(world);
  return {};
}

}  // namespace ensonify
