#include "world/place_attempt.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/units.h"

namespace ensonify {
namespace {

// Outlines that touch meet within rounding.
constexpr double kTouchM = 1e-9;

bool overlap(const Taken& a, const Taken& b, double clearance_m) {
  const Outline &p = a.outline, &q = b.outline;
  const double apart = std::hypot(p.x_m - q.x_m, p.y_m - q.y_m);
  if (apart >= p.radius_m + q.radius_m + clearance_m) return false;
  // Objects on the same ground never stand one over the other; otherwise one may be above the
  // other.
  const bool on_one_ground = !a.on.empty() && a.on == b.on;
  if (!on_one_ground && !(p.low_m < q.high_m + clearance_m && q.low_m < p.high_m + clearance_m)) {
    return false;
  }
  return gap_between(p, q).distance_m < clearance_m;
}

// Whether one lies within the circle of the other, seen from above.
bool holds(const Outline& outer, const Outline& inner) {
  return std::hypot(outer.x_m - inner.x_m, outer.y_m - inner.y_m) + inner.radius_m <=
         outer.radius_m;
}

// The height of the origin at which the rotated body, lowered at (x, y), touches the ground; none
// if part of it is outside the ground, unless that is allowed.
std::optional<double> resting_height(const Body& body, const Quat& rotation, double x, double y,
                                     bool may_be_beside = false) {
  double height = -std::numeric_limits<double>::infinity();
  Vec3 normal;
  const auto let_down = [&](Vec3 point) {
    const Vec3 p = rotate(rotation, point);
    const auto below = body.around.at(x + p.x, y + p.y);
    if (below && below->height_m - p.z > height) {
      height = below->height_m - p.z;
      normal = below->normal;
      return std::optional(true);
    }
    return below || may_be_beside ? std::optional(false) : std::nullopt;
  };
  for (const Vec3& point : body.points) {
    if (!let_down(point)) return std::nullopt;
  }
  if (std::isinf(height)) return height;  // outside all ground
  // Round bodies touch the ground between those points, where their surface faces it.
  for (int i = 0; i < 4; ++i) {
    const auto point = support_point(body.shape, rotate(conjugate(rotation), -normal));
    if (!point) break;
    const auto touches = let_down(*point);
    if (!touches) return std::nullopt;
    if (!*touches) break;
  }
  return height;
}

// The height of the origin at which a round body over (x, y) touches a round object below it. At
// the point of contact, the body faces against the normal of the object; each step halves the
// remaining angle. The search starts at several tilts toward the object, because a start straight
// down may miss it.
double round_height(const Body& body, const Quat& rotation, double x, double y,
                    const PlacedGround& thing) {
  double height = -std::numeric_limits<double>::infinity();
  const double to_x = thing.pose.position_m.x - x, to_y = thing.pose.position_m.y - y;
  const double apart = std::max(std::hypot(to_x, to_y), 1e-12);
  for (const double tilt : {0.0, 0.4, 0.8, 1.2}) {
    const double level = std::sin(tilt) / apart;
    Vec3 direction{level * to_x, level * to_y, -std::cos(tilt)};
    for (int i = 0; i < 24; ++i) {
      const auto point = support_point(body.shape, rotate(conjugate(rotation), direction));
      if (!point) return height;
      const Vec3 p = rotate(rotation, *point);
      const auto below = thing.ground->at(x + p.x, y + p.y);
      if (!below) break;
      height = std::max(height, below->height_m - p.z);
      direction = normalized(direction - below->normal);
    }
  }
  return height;
}

// The height of the origin at which no point of the objects below reaches into the rotated body
// over (x, y). This covers corners below a face, and round bodies on each other.
double height_above_heap(const Body& body, const Quat& rotation, double x, double y) {
  double height = -std::numeric_limits<double>::infinity();
  // After half a turn about x, the underside of the body is visible from above.
  const Ground underside(body.shape, {{}, Quat{0, 1, 0, 0} * rotation});
  for (std::size_t i = 1; i < body.around.grounds.size(); ++i) {
    const PlacedGround& below = body.around.grounds[i];
    height = std::max(height, round_height(body, rotation, x, y, below));
    for (const Vec3& local : contact_points(*below.shape)) {
      const Vec3 p = transform_point(below.pose, local);
      const auto face = underside.at(p.x - x, y - p.y);
      if (face) height = std::max(height, p.z + face->height_m);
    }
  }
  return height;
}

// The normal of the plane through the ground under a circle, by least squares.
std::optional<Vec3> slope_under(const PlaceGround& ground, double x, double y, double radius) {
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

// The smallest rotation from z to a normal that points upwards.
Quat turn_to(Vec3 normal) { return normalized(Quat{1 + normal.z, -normal.y, normal.x, 0}); }

// The smallest rotation of a normal to straight down.
Quat turn_down(Vec3 normal) {
  // For a normal that points straight up, any half turn about a horizontal axis will do.
  if (normal.z > 1 - 1e-12) return {0, 1, 0, 0};
  return normalized(Quat{1 - normal.z, -normal.y, normal.x, 0});
}

const RestFace& drawn_face(const std::vector<RestFace>& faces, double uniform) {
  for (const RestFace& face : faces) {
    uniform -= face.share;
    if (uniform < 0) return face;
  }
  return faces.back();
}

// A body with the rotation of one attempt.
struct Laid {
  Quat rotation;
  Outline outline;
};

std::optional<Laid> lay(const Body& body, double x_m, double y_m, const Philox4& words) {
  const PlaceSpec& place = *body.spec.place;
  const double yaw = place.any_yaw ? 2 * kPi * uniform_from_word(words.v[2]) : 0;
  const Quat turn = from_roll_pitch_yaw(0, 0, yaw);
  if (place.align == PlaceAlignment::up) {
    return Laid{turn * body.base, turned(body.outline, yaw)};
  }
  Quat rotation = body.base;
  if (place.align == PlaceAlignment::rest) {
    const RestFace& face = drawn_face(body.faces, uniform_from_word(words.v[3]));
    rotation = turn_down(face.normal) * rotation;
  }
  rotation = turn * rotation;
  const auto normal = slope_under(body.around, x_m, y_m, outline_of(body.shape, rotation).radius_m);
  if (!normal) return std::nullopt;
  rotation = turn_to(*normal) * rotation;
  return Laid{rotation, outline_of(body.shape, rotation)};
}

struct Touch {
  const Taken* other = nullptr;
  Vec3 way_m;  // to it
};

Touch nearest_on_ground(const Taken& own, const std::string& ground,
                        const std::vector<Taken>& taken) {
  Touch touch;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Taken& other : taken) {
    if (other.on != ground) continue;
    const Gap gap = gap_between(own.outline, other.outline);
    if (gap.distance_m >= nearest_m) continue;
    nearest_m = gap.distance_m;
    touch = {&other, {gap.distance_m * gap.x, gap.distance_m * gap.y, 0}};
  }
  return touch;
}

// The extent of a body along a direction, from its origin.
double reach_along(const Body& body, const Quat& rotation, Vec3 direction) {
  const Vec3 local = rotate(conjugate(rotation), direction);
  if (const auto point = support_point(body.shape, local)) return dot(*point, local);
  double reach = -std::numeric_limits<double>::infinity();
  for (const Vec3& point : body.points) reach = std::max(reach, dot(point, local));
  return reach;
}

// The name of the terrain or plane that a body in mid-water would meet; empty if there is none.
std::string met_in_water(const Body& body, const Pose& pose) {
  const double clearance = body.spec.place->clearance_m;
  const auto height =
      resting_height(body, pose.rotation, pose.position_m.x, pose.position_m.y, true);
  if (!height || pose.position_m.z < *height + clearance) return body.around.grounds.front().name;
  for (const auto& [name, plane] : body.around.planes) {
    const Vec3 normal = rotate(plane.rotation, {0, 0, 1});
    const double distance = dot(normal, pose.position_m - plane.position_m);
    const bool is_above = distance - reach_along(body, pose.rotation, -normal) >= clearance;
    const bool is_below = distance + reach_along(body, pose.rotation, normal) <= -clearance;
    if (!is_above && !is_below) return name;
  }
  return "";
}

Attempt attempt_in_water(const Body& body, const std::vector<Taken>& taken, const Philox4& words) {
  const PlaceSpec& place = *body.spec.place;
  const auto& [from, to] = *place.volume_m;
  std::array<double, 3> middle{};
  constexpr std::array<std::size_t, 3> kWords = {0, 1, 3};  // 2 is that of the yaw
  for (std::size_t i = 0; i < 3; ++i) {
    middle[i] = from[i] + uniform_from_word(words.v[kWords[i]]) * (to[i] - from[i]);
  }
  const auto laid = lay(body, middle[0], middle[1], words);
  const Outline& outline = laid->outline;
  const Pose pose{{middle[0] - outline.x_m, middle[1] - outline.y_m,
                   middle[2] - (outline.low_m + outline.high_m) / 2},
                  laid->rotation};
  const Taken own = taken_by(body.spec, outline, pose.position_m);
  if (const Taken* other = in_the_way(body, own, taken, nullptr)) {
    return {std::nullopt, other->name};
  }
  const std::string met = met_in_water(body, pose);
  if (!met.empty()) return {std::nullopt, met};
  return {pose, ""};
}

}  // namespace

Taken taken_by(const ObjectSpec& spec, const Outline& of_body, Vec3 position_m) {
  Taken taken{spec.name, "", moved(of_body, position_m), 0};
  if (spec.place) {
    if (spec.place->height_m == 0) taken.on = spec.place->on;
    taken.clearance_m = spec.place->clearance_m;
  }
  return taken;
}

bool takes_room(const Shape& shape) {
  return !is_room(shape) && !std::holds_alternative<PlaneShape>(shape);
}

std::optional<GroundPoint> PlaceGround::at(double x_m, double y_m) const {
  std::optional<GroundPoint> highest;
  for (const PlacedGround& placed : grounds) {
    const auto point = placed.ground->at(x_m, y_m);
    if (point && (!highest || point->height_m > highest->height_m)) highest = point;
  }
  return highest;
}

Result<Body> body_of(const ObjectSpec& spec, const Shape& shape, PlaceGround around) {
  const Quat base = pose_of({{}, spec.place->rotation}).rotation;
  Body body{spec, shape, std::move(around), base, contact_points(shape), outline_of(shape, base),
            {}};
  if (spec.place->align != PlaceAlignment::rest) return body;
  std::vector<Vec3> points = body.points;
  for (Vec3& point : points) point = rotate(base, point);
  Result<std::vector<RestFace>> faces = rest_faces(points);
  if (!faces) return faces.error();
  body.faces = std::move(*faces);
  return body;
}

const Taken* in_the_way(const Body& body, const Taken& own, const std::vector<Taken>& taken,
                        const Taken* touched) {
  const std::optional<Taken>& ground = body.around.ground_taken;
  for (const Taken& other : taken) {
    const bool is_ground = std::any_of(body.around.grounds.begin(), body.around.grounds.end(),
                                       [&](const auto& g) { return g.name == other.name; });
    const double clearance =
        &other == touched ? -kTouchM : std::max(own.clearance_m, other.clearance_m);
    if (is_ground || !overlap(own, other, clearance)) continue;
    // An object that surrounds the ground also surrounds everything on the ground.
    const bool is_around = other.on.empty() && ground && holds(other.outline, ground->outline);
    if (!is_around) return &other;
  }
  return nullptr;
}

Attempt attempt_to_place(const Body& body, const std::vector<Taken>& taken, const Philox4& words) {
  const PlaceSpec& place = *body.spec.place;
  if (place.volume_m) return attempt_in_water(body, taken, words);
  const auto& [from, to] = place.area_m;
  const double x = from[0] + uniform_from_word(words.v[0]) * (to[0] - from[0]);
  const double y = from[1] + uniform_from_word(words.v[1]) * (to[1] - from[1]);
  const auto laid = lay(body, x, y, words);
  if (!laid) return {};
  Vec3 origin{x - laid->outline.x_m, y - laid->outline.y_m, 0};
  Taken own = taken_by(body.spec, laid->outline, origin);
  Touch touch;
  if (place.touching) {
    touch = nearest_on_ground(own, place.on, taken);
    if (touch.other == nullptr) return {};
    origin = origin + touch.way_m;
    own = taken_by(body.spec, laid->outline, origin);
  }
  // The cheap test comes first.
  for (const Taken& other : taken) {
    if (own.on.empty() || other.on != own.on || place.heap) continue;
    const double clearance =
        &other == touch.other ? -kTouchM : std::max(own.clearance_m, other.clearance_m);
    if (overlap(own, other, clearance)) return {std::nullopt, other.name};
  }
  auto height = resting_height(body, laid->rotation, origin.x, origin.y);
  if (!height) return {};
  if (place.heap) {
    height = std::max(*height, height_above_heap(body, laid->rotation, origin.x, origin.y));
  }
  const double tall_m = laid->outline.high_m - laid->outline.low_m;
  origin.z = *height + place.height_m - place.sink_m - place.buried_fraction * tall_m;
  own = taken_by(body.spec, laid->outline, origin);
  if (const Taken* other = in_the_way(body, own, taken, touch.other)) {
    return {std::nullopt, other->name};
  }
  return {Pose{origin, laid->rotation}, ""};
}

}  // namespace ensonify
