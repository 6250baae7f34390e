#include "app/motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acoustics/propagation.h"
#include "synthesis/backend.h"
#include "trace/motion.h"

namespace ensonify {
namespace {

constexpr std::size_t kMostPings = 64;  // looked at for speeds
constexpr double kSpeedStep_s = 1e-3;
constexpr double kMargin = 1.0 / 8;
constexpr double kLeast = 1e-9;  // a body that may move, but was not seen to

bool has_one_pose(const Path& path) {
  const auto* sampled = std::get_if<SampledWay>(&path.way);
  return sampled != nullptr && sampled->points.size() == 1 && !path.jitter;
}

// Of the pings that are looked at: when they go out, when half their sound is back and when all is.
std::vector<double> times_of(const Session& session) {
  const double span_s = two_way_delay_s(session.sonar.range_max_m, session.water.sound_speed_m_s);
  const std::vector<double>& pings = session.ping_times_s;
  std::vector<double> times;
  for (std::size_t i = 0; i < std::min(kMostPings, pings.size()); ++i) {
    const double start = pings[i * pings.size() / std::min(kMostPings, pings.size())];
    for (const double part : {0.0, 0.5, 1.0}) times.push_back(start + part * span_s);
  }
  return times;
}

template <class PoseAt>
Vec3 velocity(double time_s, const PoseAt& pose_at) {
  const double later_s = time_s + kSpeedStep_s;
  return (1 / (later_s - time_s)) * (pose_at(later_s).position_m - pose_at(time_s).position_m);
}

// Towards what the fan sees.
std::vector<Vec3> directions_of(const Sonar& sonar) {
  std::vector<Vec3> directions;
  const double half_fan = sonar.beam_count * sonar.beam_spacing_rad / 2;
  for (const double azimuth : {-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0}) {
    for (const double elevation : {-1.0, 0.0, 1.0}) {
      directions.push_back(
          unit_vector(azimuth * half_fan, elevation * sonar.elevation_fan_rad / 2));
    }
  }
  return directions;
}

}  // namespace

bool moves(const Session& session) {
  if (!session.scenario.motion_within_ping) return false;
  const auto& objects = session.world.objects;
  return !has_one_pose(session.path) ||
         std::any_of(objects.begin(), objects.end(), [](const WorldObject& object) {
           return object.path != nullptr && !has_one_pose(*object.path);
         });
}

DopplerRange doppler_range(const Session& session) {
  if (!moves(session)) return {};
  const std::vector<double> times = times_of(session);
  const std::vector<Vec3> directions = directions_of(session.sonar);
  const auto sonar_at = [&](double t) { return compose(pose_at(session.path, t), session.mount); };
  double lowest = HUGE_VAL, highest = -HUGE_VAL, object = 0;
  for (const double time : times) {
    const Vec3 v = rotate(conjugate(sonar_at(time).rotation), velocity(time, sonar_at));
    for (const Vec3& u : directions) {
      lowest = std::min(lowest, dot(v, u));
      highest = std::max(highest, dot(v, u));
    }
  }
  for (const WorldObject& moving : session.world.objects) {
    if (moving.path == nullptr) continue;
    const auto object_at = [&](double t) { return object_pose(moving, t); };
    for (const double time : times) object = std::max(object, length(velocity(time, object_at)));
  }
  const double margin = kMargin * (highest - lowest + 2 * object);
  const double per_speed = 2 / session.water.sound_speed_m_s;
  return {per_speed * (lowest - object - margin) - kLeast,
          per_speed * (highest + object + margin) + kLeast};
}

Status check_motion(const Session& session) {
  if (!session.scenario.motion_within_ping) return {};
  if (can_shift(
          {session.sonar, session.water, session.record, session.scenario.synthesis_tolerance})) {
    return {};
  }
  const bool table = session.sonar.pulse.shape == PulseShape::table;
  return Error{ErrorKind::usage,
               std::string("motion_within_ping: the echoes of ") +
                   (table ? "a measured pulse (sonar.pulse.table)" : "so long a pulse") +
                   " cannot be shifted; accepted are gaussian, flat, lfm and a shorter cw"};
}

void move(const Moment& moment, const Workers& workers, PingEchoes& echoes) {
  const Session& session = moment.session;
  if (!moves(session)) return;
  const Movement movement =
      movement_of(session.world, session.path, session.mount, session.ping_times_s[moment.ping],
                  session.sonar, session.water, workers);
  if (rests(movement)) return;
  const auto moved = [&](const ScattererList& list) {
    return move_echoes(list, movement, session.sonar, session.water, workers);
  };
  echoes.scatterers = moved(echoes.scatterers).list;
  if (!moment.wants_hidden) return;
  MovedEchoes hidden = moved(echoes.hidden.list);
  std::vector<std::uint32_t> caster;
  for (const std::uint32_t before : hidden.origin) caster.push_back(echoes.hidden.caster[before]);
  echoes.hidden.list = std::move(hidden.list);
  echoes.hidden.caster = std::move(caster);
}

}  // namespace ensonify
