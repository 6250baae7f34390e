#include "app/motion.h"

#include <algorithm>
#include <utility>

#include "acoustics/propagation.h"
#include "synthesis/backend.h"
#include "trace/motion.h"

namespace ensonify {
namespace {

constexpr std::size_t kMostPings = 64;  // looked at for speeds
constexpr double kSpeedStep_s = 1e-3;
constexpr double kMargin = 1.25;
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
double fastest(const std::vector<double>& times, const PoseAt& pose_at) {
  double speed = 0;
  for (const double time : times) {
    const Vec3 step = pose_at(time + kSpeedStep_s).position_m - pose_at(time).position_m;
    speed = std::max(speed, length(step) / ((time + kSpeedStep_s) - time));
  }
  return speed;
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

double max_doppler(const Session& session) {
  if (!moves(session)) return 0;
  const std::vector<double> times = times_of(session);
  const double sonar =
      fastest(times, [&](double t) { return compose(pose_at(session.path, t), session.mount); });
  double objects = 0;
  for (const WorldObject& object : session.world.objects) {
    if (object.path == nullptr) continue;
    objects = std::max(objects, fastest(times, [&](double t) { return object_pose(object, t); }));
  }
  return std::max(kLeast, kMargin * 2 * (sonar + objects) / session.water.sound_speed_m_s);
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
