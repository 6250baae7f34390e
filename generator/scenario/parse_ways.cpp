#include <cmath>

#include <fmt/format.h>

#include "scenario/parse.h"
#include "scenario/parse_ways.h"

namespace ensonify {
namespace {

constexpr NumberRange kSpeed = above_up_to(0, 1e4);
constexpr NumberRange kBearing = from_to(-36000, 36000);

Vec3 vector_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

// Nearer points have no direction between them.
constexpr double kLeastStepM = 1e-6;
// Of the sum of two unit vectors: directions closer to opposite than 0.06 degrees.
constexpr double kLeastBisector = 1e-3;

void check_points(Faults& faults, const Value& list, const SplineSpec& spline) {
  for (std::size_t i = 1; i < spline.points_m.size(); ++i) {
    const Value point = item(list, i);
    const Vec3 step = vector_of(spline.points_m[i]) - vector_of(spline.points_m[i - 1]);
    if (length(step) < kLeastStepM) {
      add_fault(faults, point.place, point.path,
                "stands where the point before it stands, accepted are points at least 1e-6 m "
                "apart from one to the next");
      return;
    }
    if (i + 1 == spline.points_m.size()) return;
    const Vec3 next = vector_of(spline.points_m[i + 1]) - vector_of(spline.points_m[i]);
    if (length(normalized(step) + normalized(next)) < kLeastBisector) {
      add_fault(faults, point.place, point.path,
                "the way doubles back here and has no direction, accepted are turns of less than "
                "180 degrees; set one more point beside this one");
      return;
    }
  }
}

void parse_points(Faults& faults, const Value& map, SplineSpec& spline) {
  const auto list = child(map, "points_m");
  if (!list) {
    add_fault(faults, map.place, path_of(map, "points_m"),
              "missing, accepted is a list of at least two points [x, y, z]");
    return;
  }
  if (!open_list(faults, *list)) return;
  const std::size_t count = list->node->items.size();
  if (count < 2) {
    add_fault(faults, list->place, list->path,
              fmt::format("a list of {} stands here, accepted is a list of at least two points "
                          "[x, y, z]",
                          count));
    return;
  }
  spline.points_m.assign(count, {});
  bool whole = true;
  for (std::size_t i = 0; i < count; ++i) {
    whole &= read_numbers_of(faults, item(*list, i), kPosition, spline.points_m[i].data(), 3);
  }
  if (whole) check_points(faults, *list, spline);
}

}  // namespace

void parse_lawnmower(Faults& faults, const Value& map, LawnmowerSpec& way) {
  if (!open_map(faults, map,
                {"corner_m", "length_m", "width_m", "spacing_m", "heading_deg", "speed_m_s",
                 "start_time_s"})) {
    return;
  }
  read_numbers(faults, map, "corner_m", kPosition, way.corner_m, Need::required);
  read_number(faults, map, "length_m", kLength, way.length_m, Need::required);
  read_number(faults, map, "width_m", from_to(0, kMaxLengthM), way.width_m, Need::required);
  read_number(faults, map, "spacing_m", kLength, way.spacing_m, Need::required);
  read_number(faults, map, "heading_deg", kBearing, way.heading_deg);
  read_number(faults, map, "speed_m_s", kSpeed, way.speed_m_s, Need::required);
  read_number(faults, map, "start_time_s", kPathTime, way.start_time_s);
}

void parse_orbit(Faults& faults, const Value& map, OrbitSpec& way) {
  if (!open_map(
          faults, map,
          {"center_m", "radius_m", "speed_m_s", "turns", "start_deg", "look", "start_time_s"})) {
    return;
  }
  read_numbers(faults, map, "center_m", kPosition, way.center_m, Need::required);
  read_number(faults, map, "radius_m", kLength, way.radius_m, Need::required);
  read_number(faults, map, "speed_m_s", kSpeed, way.speed_m_s, Need::required);
  if (read_number(faults, map, "turns", from_to(-1e6, 1e6), way.turns) &&
      std::abs(way.turns) < 1e-9) {
    const Value turns = *child(map, "turns");
    add_fault(faults, turns.place, turns.path,
              "no way to go, accepted is a number other than 0, below 0 for clockwise");
  }
  read_number(faults, map, "start_deg", kBearing, way.start_deg);
  read_choice<OrbitLook>(
      faults, map, "look",
      {{"inward", OrbitLook::inward}, {"outward", OrbitLook::outward}, {"along", OrbitLook::along}},
      way.look);
  read_number(faults, map, "start_time_s", kPathTime, way.start_time_s);
}

void parse_spline(Faults& faults, const Value& map, SplineSpec& way) {
  if (!open_map(faults, map, {"points_m", "speed_m_s", "look", "start_time_s"})) return;
  parse_points(faults, map, way);
  read_number(faults, map, "speed_m_s", kSpeed, way.speed_m_s, Need::required);
  if (const auto look = read_kind(faults, map, "look", {"along", "at_m"})) {
    std::array<double, 3> at{};
    if (look->word == "at_m" &&
        read_numbers(faults, *child(map, "look"), "at_m", kPosition, at, Need::required)) {
      way.look_at_m = at;
    }
    if (look->word == "along") open_map(faults, look->options, {});
  }
  read_number(faults, map, "start_time_s", kPathTime, way.start_time_s);
}

void parse_jitter(Faults& faults, const Value& map, JitterSpec& jitter) {
  if (!open_map(faults, map,
                {"roll_deg", "pitch_deg", "yaw_deg", "heave_m", "period_s", "bandwidth"})) {
    return;
  }
  read_number(faults, map, "roll_deg", from_to(0, 60), jitter.roll_deg);
  read_number(faults, map, "pitch_deg", from_to(0, 60), jitter.pitch_deg);
  read_number(faults, map, "yaw_deg", from_to(0, 60), jitter.yaw_deg);
  read_number(faults, map, "heave_m", from_to(0, 1000), jitter.heave_m);
  read_number(faults, map, "period_s", above_up_to(0, 1e6), jitter.period_s, Need::required);
  read_number(faults, map, "bandwidth", from_to(0.01, 0.33), jitter.bandwidth);
}

}  // namespace ensonify
