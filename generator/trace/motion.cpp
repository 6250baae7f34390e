#include "trace/motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "trace/echo.h"

namespace ensonify {
namespace {

constexpr double kExact_s = 1e-15, kNear_s = 1e-9;
constexpr int kMostSteps = 60;  // enough for a body at half the speed of sound
// If the sonar moves away from the last scatterer, the echo arrives later than the delay of the
// largest range.
constexpr double kSpanMargin = 1.05;

// Solves t = value(t) by iteration from a first guess. From the second step on, the slope between
// the last two values leads close to the solution. After such a step of kNear_s, what is left is
// smaller by the change of the slope over the step before, which is below 1e-6 even at half the
// speed of sound.
template <class Value>
double fixed_point(double t, const Value& value) {
  double before = t, value_before = t;
  for (int i = 0; i < kMostSteps; ++i) {
    const double next = value(t), step = next - t;
    if (std::abs(step) < kExact_s) return next;
    const double slope = i == 0 ? 0 : (next - value_before) / (t - before);
    before = t;
    value_before = next;
    t = std::abs(slope) < 0.9 ? t + step / (1 - slope) : next;
    if (i > 0 && std::abs(t - before) < kNear_s) return t;
  }
  return t;
}

Direction direction_of(double azimuth_rad, Vec3 unit) {
  return {static_cast<float>(azimuth_rad),
          static_cast<float>(std::asin(std::clamp(unit.z, -1.0, 1.0)))};
}

// The factor by which motion changes the gain of an echo, relative to everything at rest.
double change_of_gain(const Scatterer& before, const Flight& flight, const Flight& still,
                      Direction departure, Direction arrival, const Sonar& sonar,
                      const Water& water) {
  // Most echoes leave and arrive in the same direction before they move, and leave in it after.
  const double sent_rad = double{before.departure.elevation_rad};
  const double sent = elevation_pattern(sonar, sent_rad);
  const auto elevation = [&](float angle_rad) {
    return double{angle_rad} == sent_rad ? sent : elevation_pattern(sonar, double{angle_rad});
  };
  const auto azimuth = [&](Direction direction) {
    return transmit_pattern(static_cast<double>(direction.azimuth_rad), sonar.transmit_width_rad);
  };
  double was = two_direction_pattern(sent, elevation(before.arrival.elevation_rad));
  double is =
      two_direction_pattern(elevation(departure.elevation_rad), elevation(arrival.elevation_rad));
  if (departure.azimuth_rad != before.departure.azimuth_rad) {
    was *= azimuth(before.departure);
    is *= azimuth(departure);
  }
  if (was == 0) return 0;  // the gain is zero, too
  const double further_m = flight.out_m + flight.in_m - still.out_m - still.in_m;
  constexpr double kLn10 = 2.302585092994045684;  // exp is half the time of pow
  return still.out_m * still.in_m / (flight.out_m * flight.in_m) *
         std::exp(-water.absorption_db_m * further_m * (kLn10 / 20)) * is / was;
}

// False if the echo is not heard.
bool move_echo(const Movement& movement, const Sonar& sonar, const Water& water, Scatterer& s) {
  const PoseTrack* object = nullptr;
  if (s.path == 0 && s.instance < movement.object.size() && movement.object[s.instance]) {
    object = &*movement.object[s.instance];
  }
  const double c = water.sound_speed_m_s;
  const Flight flight = s.path == 0 ? direct_flight(movement, object, s.position_m, c)
                                    : bounced_flight(movement, s, c);
  if (!in_range(c * flight.delay_s / 2, sonar)) return false;
  const Vec3 heard = rotate(conjugate(flight.heard_from.rotation), flight.arrival);
  const double azimuth_rad = std::atan2(heard.y, heard.x);
  const std::optional<int> beam = sector_of(sonar, azimuth_rad);
  if (!beam) return false;
  Flight still;
  still.in_m = s.path == 0 ? length(s.position_m) : static_cast<double>(s.received_path_m);
  still.out_m = s.path == 0 ? still.in_m : flight.out_m;
  const Direction arrival = direction_of(azimuth_rad, heard);
  Direction departure = s.departure;
  if (object != nullptr) {
    const Vec3 sent = rotate(conjugate(movement.sent_from.rotation), flight.departure);
    departure = direction_of(std::atan2(sent.y, sent.x), sent);
  }
  s.gain = static_cast<float>(s.gain *
                              change_of_gain(s, flight, still, departure, arrival, sonar, water));
  s.delay_s = flight.delay_s + static_cast<double>(s.lag_s);
  s.departure = departure;
  s.arrival = arrival;
  s.received_path_m = static_cast<float>(flight.in_m);
  s.doppler = static_cast<float>(flight.doppler);
  s.beam = static_cast<std::uint32_t>(*beam);
  return true;
}

// The formula of direct_flight. thrown_v: velocity of the scatterer; sent_v, heard_v: of the sonar
// at transmission and reception.
double doppler_of(const Flight& flight, Vec3 sent_v, Vec3 heard_v, Vec3 thrown_v,
                  double sound_speed_m_s) {
  const auto mach = [&](Vec3 unit, Vec3 v) { return dot(unit, v) / sound_speed_m_s; };
  const double above = (1 - mach(flight.departure, thrown_v)) * (1 + mach(flight.arrival, heard_v));
  const double below = (1 - mach(flight.departure, sent_v)) * (1 + mach(flight.arrival, thrown_v));
  return (above - below) / below;
}

}  // namespace

Movement movement_of(const World& world, const Path& body, const Pose& mount, double time_s,
                     const Sonar& sonar, const Water& water, const Workers& workers) {
  const double span_s = kSpanMargin * two_way_delay_s(sonar.range_max_m, water.sound_speed_m_s);
  const auto sonar_at = [&body, mount](double t) { return compose(pose_at(body, t), mount); };
  Movement movement{PoseTrack(sonar_at, time_s, span_s)};
  movement.object.resize(world.instances.size() + 1);
  workers.for_each(world.objects.size(), [&](std::size_t i) {
    const WorldObject& object = world.objects[i];
    if (object.path == nullptr) return;
    const auto object_at = [&object](double t) { return object_pose(object, t); };
    PoseTrack track(object_at, time_s, span_s);
    if (!track.rests()) movement.object[object.instance] = std::move(track);
  });
  return movement;
}

bool rests(const Movement& movement) {
  return movement.sonar.rests() &&
         std::none_of(movement.object.begin(), movement.object.end(),
                      [](const std::optional<PoseTrack>& track) { return track.has_value(); });
}

Flight direct_flight(const Movement& movement, const PoseTrack* object, Vec3 point_m,
                     double sound_speed_m_s) {
  const double c = sound_speed_m_s;
  const Pose& sent_from = movement.sent_from;
  const Vec3 at_transmission = rotate(sent_from.rotation, point_m);  // relative to p(0)
  Vec3 thrown = at_transmission, local, velocity;
  double out_s = length(at_transmission) / c;
  if (object != nullptr) {
    local = inverse_transform_point(object->at(0), sent_from.position_m + at_transmission);
    const Vec3 first = transform_point(object->at(0), local);
    const auto point = [&](double t) {
      return at_transmission + (transform_point(object->at(t), local) - first);
    };
    out_s = fixed_point(out_s, [&](double t) { return length(point(t)) / c; });
    thrown = point(out_s);
    velocity = object->velocity(out_s, local);
  }
  const auto way_back = [&](double t) {
    return thrown - (movement.sonar.position(t) - sent_from.position_m);
  };
  Flight flight;
  flight.delay_s =
      fixed_point(2 * out_s, [&](double t) { return out_s + length(way_back(t)) / c; });
  flight.heard_from = movement.sonar.at(flight.delay_s);
  const Vec3 back = thrown - (flight.heard_from.position_m - sent_from.position_m);
  flight.out_m = length(thrown);
  flight.in_m = length(back);
  flight.departure = (1 / flight.out_m) * thrown;
  flight.arrival = (1 / flight.in_m) * back;
  flight.doppler = doppler_of(flight, movement.sent_velocity,
                              movement.sonar.velocity(flight.delay_s), velocity, c);
  return flight;
}

Flight bounced_flight(const Movement& movement, const Scatterer& s, double sound_speed_m_s) {
  const double c = sound_speed_m_s;
  const Pose& sent_from = movement.sent_from;
  const auto unit = [&](Direction d) {
    return rotate(sent_from.rotation, unit_vector(static_cast<double>(d.azimuth_rad),
                                                  static_cast<double>(d.elevation_rad)));
  };
  const double path_m = static_cast<double>(s.received_path_m);
  const double whole_s = s.delay_s - static_cast<double>(s.lag_s);
  const Vec3 apparent = path_m * unit(s.arrival);
  const auto way_back = [&](double t) {
    return apparent - (movement.sonar.position(t) - sent_from.position_m);
  };
  Flight flight;
  flight.delay_s =
      fixed_point(whole_s, [&](double t) { return whole_s + (length(way_back(t)) - path_m) / c; });
  flight.heard_from = movement.sonar.at(flight.delay_s);
  const Vec3 back = way_back(flight.delay_s);
  flight.out_m = c * whole_s - path_m;
  flight.in_m = length(back);
  flight.departure = unit(s.departure);
  flight.arrival = (1 / flight.in_m) * back;
  flight.doppler =
      doppler_of(flight, movement.sent_velocity, movement.sonar.velocity(flight.delay_s), {}, c);
  return flight;
}

MovedEchoes move_echoes(ScattererList list, const Movement& movement, const Sonar& sonar,
                        const Water& water, const Workers& workers) {
  constexpr std::size_t kBlock = 1024;
  const std::size_t count = list.size(), blocks = (count + kBlock - 1) / kBlock;
  std::vector<std::uint64_t> key(count);
  std::vector<std::size_t> heard(blocks);
  workers.for_each(blocks, [&](std::size_t block) {
    const std::size_t begin = block * kBlock, end = std::min(begin + kBlock, count);
    for (std::size_t i = begin; i < end; ++i) {
      Scatterer& s = list.items[i];
      key[i] = s.key;
      // The index orders equal delays as the key did, and becomes `origin` below.
      s.key = i;
      if (!move_echo(movement, sonar, water, s)) continue;
      Scatterer& kept = list.items[begin + heard[block]++];
      if (&kept != &s) kept = s;
    }
  });
  // Closes the gaps of echoes that are not heard.
  auto last = list.items.begin();
  for (std::size_t block = 0; block < blocks; ++block) {
    const auto first = list.items.begin() + static_cast<std::ptrdiff_t>(block * kBlock);
    const auto end = first + static_cast<std::ptrdiff_t>(heard[block]);
    last = first == last ? end : std::copy(first, end, last);
  }
  list.items.erase(last, list.items.end());
  MovedEchoes moved{sorted_by_beam_and_delay(list.items, sonar.beam_count, workers), {}};
  moved.origin.reserve(moved.list.size());
  for (Scatterer& s : moved.list.items) {
    moved.origin.push_back(static_cast<std::uint32_t>(s.key));
    s.key = key[moved.origin.back()];
  }
  return moved;
}

}  // namespace ensonify
