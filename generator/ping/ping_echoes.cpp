#include "ping/ping_echoes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acoustics/propagation.h"
#include "core/random.h"
#include "core/stage_times.h"
#include "ping/group_echoes.h"
#include "synthesis/carriers.h"
#include "trace/bounces.h"
#include "trace/front.h"
#include "trace/motion.h"
#include "trace/multipath.h"
#include "trace/piece_echoes.h"
#include "trace/refracted.h"
#include "trace/scatter.h"
#include "trace/surface_points.h"
#include "trace/volume.h"

namespace ensonify {
namespace {

constexpr std::size_t kMostPings = 64;  // at which speeds are computed
constexpr double kSpeedStep_s = 1e-3;
constexpr double kMargin = 1.0 / 8;
constexpr double kLeast = 1e-9;  // for a body that may move but did not at these times

bool has_one_pose(const Path& path) {
  const auto* carried = std::get_if<CarriedPath>(&path.nominal);
  if (carried != nullptr) return has_one_pose(*carried->carrier);
  const auto* sampled = std::get_if<SampledPath>(&path.nominal);
  return sampled != nullptr && sampled->points.size() == 1 && !path.wave_motion;
}

// When the last group of beams transmits, after the ping's time.
double last_group_s(const Session& session) {
  const int groups = group_count(session.sonar);
  return groups == 1 ? 0 : session.sonar.transmit->interval_s * (groups - 1);
}

// The times at which speeds are computed: when a ping is transmitted, when half of its sound has
// returned and when all of it has.
std::vector<double> times_of(const Session& session) {
  const double span_s = two_way_delay_s(session.sonar.range_max_m, session.water.sound_speed_m_s) +
                        last_group_s(session);
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

// The direction toward the center of the fan.
std::vector<Vec3> directions_of(const Sonar& sonar) {
  std::vector<Vec3> directions;
  const double half_fan = furthest_azimuth_rad(sonar);
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
  // The highest carrier needs most.
  const Sonar& sonar = session.sonar;
  double higher_hz = 0;
  for (int group = 0; group < group_count(sonar); ++group) {
    higher_hz = std::max(higher_hz, carrier_hz(sonar, group) - sonar.frequency_hz);
  }
  SynthesisSetup setup{sonar, session.water, session.record, session.scenario.synthesis_tolerance};
  shift_carriers(setup.sonar, higher_hz);
  if (can_shift(setup)) return {};
  const bool table = sonar.pulse.shape == PulseShape::table;
  return Error{ErrorKind::usage,
               std::string("motion_within_ping: the Doppler of ") +
                   (table ? "a measured pulse (sonar.pulse.table)" : "such a long pulse") +
                   " cannot be computed; expected gaussian, flat, lfm or a shorter cw"};
}

namespace {

PointScatterers point_scatterers(const Moment& moment, const Workers& workers) {
  const auto& [session, fan, scattering, tracer, ping, pose, with_hidden, places_key, with_front,
               volume_step_rad, after_s, traced, all_hits] = moment;
  PointScatterers points;
  std::vector<HiddenTarget>* hidden = with_hidden ? &points.hidden : nullptr;
  points.heard =
      point_target_scatterers(session.world, tracer, pose, session.sonar, session.water, hidden);
  const std::vector<Scatterer> fish =
      school_scatterers(session.world, tracer, pose, session.sonar, session.water, workers, hidden);
  points.heard.insert(points.heard.end(), fish.begin(), fish.end());
  return points;
}

// Scatterers of surfaces are fixed on them, or there is one for each ray.
ScattererList surface_echoes(const Moment& moment, std::span<const Hit> hits,
                             std::span<const RayPath> paths, const Workers& workers) {
  const auto& [session, fan, scattering, tracer, ping, pose, with_hidden, places_key, with_front,
               volume_step_rad, after_s, traced, all_hits] = moment;
  if (const auto& tiles = session.surface_tiles) {
    return surface_point_list(*tiles, tracer, object_poses_at(session, moment.time_s()), pose,
                              scattering, places_key, workers);
  }
  ScattererList list = session.sonar.rays_per_cell == 0
                           ? surface_scatterer_list(fan, hits, scattering, workers, paths)
                           : adaptive_surface_scatterers(fan, {hits, paths, all_hits}, session.cell,
                                                         tracer, pose, scattering, workers);
  return with_all_beams(fan, std::move(list), session.sonar.beam_count);
}

// Echoes without a ray of their own: specular echoes, point targets, fish and multipath.
struct OtherEchoes {
  std::vector<Scatterer> heard;
  PointScatterers points;
  std::uint64_t most = 0;  // in memory at once, before both directions of a path are merged
};

OtherEchoes other_echoes(const Moment& moment, const std::vector<Hit>& hits,
                         const Workers& workers) {
  const Session& session = moment.session;
  OtherEchoes other;
  std::vector<Scatterer>& heard = other.heard;
  heard = kirchhoff_scatterers(moment.fan, hits, moment.tracer, moment.sonar_in_world,
                               moment.scattering, workers, moment.all_hits);
  with_all_beams(moment.fan, heard);
  const std::vector<Pose> objects = object_poses_at(session, moment.time_s());
  other.points = point_scatterers(moment, workers);
  const PlacedWorld placed{session.world, moment.tracer, objects, moment.sonar_in_world};
  for (const std::vector<Scatterer>& more :
       {edge_scatterers(placed, moment.scattering, workers),
        elastic_scatterers(placed, session.sonar, session.water, workers,
                           moment.with_hidden ? &other.points.hidden : nullptr)}) {
    heard.insert(heard.end(), more.begin(), more.end());
  }
  heard.insert(heard.end(), other.points.heard.begin(), other.points.heard.end());
  other.most = heard.size();
  // Motion separates the two directions of a path: the places of an element at both arrivals
  // differ.
  const bool same = !session.sonar.array && !moves(session);
  if (session.scenario.bounces > 0 || !moment.scattering.walls.empty()) {
    const bool fixed = session.scenario.scattering.speckle != SpeckleMode::per_ping;
    const std::vector<Scatterer> bounced = bounced_off_surfaces(
        {moment.tracer, session.world.volumes, moment.sonar_in_world, moment.scattering,
         session.scenario.bounces, same, stream_key(moment.places_key, Stream::bounces, 0),
         fixed ? 0 : moment.ping},
        moment.fan, hits, workers);
    heard.insert(heard.end(), bounced.begin(), bounced.end());
    other.most += bounced.size();
  }
  if (session.bounces.paths.empty()) return other;
  std::vector<Scatterer> bounced =
      bounced_echoes({session.bounces, session.world, moment.tracer, objects, moment.sonar_in_world,
                      moment.scattering},
                     moment.fan, hits, workers);
  other.most += bounced.size();
  if (same) bounced = both_ways_as_one(std::move(bounced));
  heard.insert(heard.end(), bounced.begin(), bounced.end());
  return other;
}

// The echoes with everything at its position at transmission.
PingEchoes echoes_at_rest(const Moment& moment, const Workers& workers) {
  const auto& [session, fan, scattering, tracer, ping, pose, with_hidden, places_key, with_front,
               volume_step_rad, after_s, traced, all_hits] = moment;
  const auto [hits, paths] = traced != nullptr ? *traced : timed(workers, Stage::trace, [&] {
    return trace_fan(moment.tracer, moment.fan, moment.sonar_in_world, moment.session.sonar,
                     moment.session.water, workers);
  });
  std::optional<StageTimer> timer(std::in_place, workers, Stage::scatterers);
  const OtherEchoes other = other_echoes(moment, hits, workers);
  PingEchoes echoes;
  if (with_front) echoes.front = front_view(fan, hits, paths, scattering, pose, workers);
  echoes.scatterers = with_more(surface_echoes(moment, hits, paths, workers), other.heard, workers);
  attenuate(echoes.scatterers, session.world.volumes, pose, session.sonar, session.water, workers);
  echoes.volumes = volume_echoes(fan, hits, session.world.volumes, pose, session.sonar,
                                 session.water, session.record, workers);
  if (volume_step_rad > 0) {
    echoes.volume_elevation =
        volume_elevation_echoes(fan, hits, session.world.volumes, pose, session.sonar,
                                session.water, session.record, volume_step_rad, workers);
  }
  if (!with_hidden) return echoes;
  timer.emplace(workers, Stage::hidden);
  const FanHitsBehind behind =
      trace_behind(tracer, fan, hits, pose, session.sonar, session.water, workers);
  echoes.hidden = hidden_echoes(fan, hits, behind, points_of_cells(fan, other.points), scattering,
                                session.world.instances.size(), workers);
  echoes.hidden.list =
      with_all_beams(fan, std::move(echoes.hidden.list), session.sonar.beam_count, false);
  attenuate(echoes.hidden.list, session.world.volumes, pose, session.sonar, session.water, workers);
  return echoes;
}

// Moves scatterers and hidden echoes by move_echoes, but not volumes. Empty if nothing moves.
void move(const Moment& moment, const Workers& workers, PingEchoes& echoes) {
  const Session& session = moment.session;
  if (!moves(session)) return;
  const Movement movement = movement_of(session.world, session.path, session.mount, moment.time_s(),
                                        session.sonar, session.water, workers);
  if (rests(movement)) return;
  const auto moved = [&](Stage stage, ScattererList& list) {
    const StageTimer timer(workers, stage);
    return move_echoes(std::move(list), movement, session.sonar, session.water, workers);
  };
  echoes.scatterers = moved(Stage::scatterers, echoes.scatterers).list;
  if (!moment.with_hidden) return;
  MovedEchoes hidden = moved(Stage::hidden, echoes.hidden.list);
  std::vector<std::uint32_t> occluder;
  for (const std::uint32_t before : hidden.origin)
    occluder.push_back(echoes.hidden.occluder[before]);
  echoes.hidden.list = std::move(hidden.list);
  echoes.hidden.occluder = std::move(occluder);
}

// Of the group of beams whose cells the fan of the moment has.
PingEchoes echoes_of_group(const Moment& moment, int group, const Workers& workers) {
  const Session& session = moment.session;
  PingEchoes part = echoes_at_rest(moment, workers);
  keep_if(part.scatterers, session.sonar.beam_count,
          [&](const Scatterer& s) { return in_group(session.sonar, s, group); });
  move(moment, workers, part);
  const Pose to_ping = pose_in(sonar_pose(session, moment.ping), moment.sonar_in_world);
  for (ScattererList* list : {&part.scatterers, &part.hidden.list}) {
    for (Scatterer& s : list->items) s.position_m = transform_point(to_ping, s.position_m);
  }
  return part;
}

// A group as it transmits.
struct GroupView {
  double after_s = 0;
  Pose sonar_in_world;
  Tracer tracer;
  Fan fan;
  FanHits met = {};
};

std::vector<GroupView> group_views(const Moment& moment, const Workers& workers) {
  const Session& session = moment.session;
  const int groups = group_count(session.sonar);
  std::vector<GroupView> views;
  for (int group = 0; group < groups; ++group) {
    const double after_s = fired_after_s(session.sonar, group), time_s = moment.time_s() + after_s;
    const GroupBeams beams = beams_of_group(session.sonar, group);
    views.push_back({after_s, sonar_pose_at(session, time_s),
                     moment.tracer.at(object_poses_at(session, time_s)),
                     fan_of_group(moment.fan, beams.first, beams.step, beams.count)});
    GroupView& view = views.back();
    const StageTimer timer(workers, Stage::trace);
    view.met = trace_fan(view.tracer, view.fan, view.sonar_in_world, session.sonar, session.water,
                         workers);
  }
  return views;
}

// In the order of the whole fan.
std::vector<Hit> hits_of_all(const std::vector<GroupView>& views, const Fan& whole) {
  std::vector<Hit> hits(whole.size());
  const auto rays = static_cast<std::ptrdiff_t>(whole.rays_per_beam());
  for (const GroupView& view : views) {
    for (int cell = 0; cell < view.fan.beams; ++cell) {
      std::copy_n(view.met.hits.begin() + cell * rays, rays,
                  hits.begin() + view.fan.beam_of(static_cast<std::size_t>(cell)) * rays);
    }
  }
  return hits;
}

PingEchoes echoes_in_turn(const Moment& moment, const Workers& workers) {
  const Session& session = moment.session;
  const std::vector<GroupView> views = group_views(moment, workers);
  const std::vector<Hit> all_hits = hits_of_all(views, moment.fan);
  GroupEchoes all(session.sonar, session.record.samples);
  for (std::size_t group = 0; group < views.size(); ++group) {
    const GroupView& view = views[group];
    all.add(view.fan,
            echoes_of_group({session, view.fan, moment.scattering, view.tracer, moment.ping,
                             view.sonar_in_world, moment.with_hidden, moment.places_key, false,
                             moment.volume_step_rad, view.after_s, &view.met, all_hits},
                            static_cast<int>(group), workers));
  }
  PingEchoes echoes = std::move(all).joined(workers);
  if (!moment.with_front) return echoes;
  const auto [hits, paths] = trace_fan(moment.tracer, moment.fan, moment.sonar_in_world,
                                       session.sonar, session.water, workers);
  echoes.front =
      front_view(moment.fan, hits, paths, moment.scattering, moment.sonar_in_world, workers);
  return echoes;
}

PingEchoes echoes_at_once(const Moment& moment, const Workers& workers) {
  PingEchoes echoes = echoes_at_rest(moment, workers);
  move(moment, workers, echoes);
  const Sonar& sonar = moment.session.sonar;
  if (group_count(sonar) > 1) {
    keep_if(echoes.scatterers, sonar.beam_count,
            [&](const Scatterer& s) { return same_group_both_ways(sonar, s); });
  }
  return echoes;
}

}  // namespace

bool has_pictures(const OutputSelection& output) {
  return output.polar || output.cartesian || output.png;
}

bool wants_hidden(const OutputSelection& output) {
  return has_pictures(output) && (output.shadow || output.amodal);
}

bool transmit_in_turn(const Session& session) {
  return last_group_s(session) > 0 && moves(session);
}

PingEchoes ping_echoes(const Moment& moment, const Workers& workers) {
  PingEchoes echoes = transmit_in_turn(moment.session) ? echoes_in_turn(moment, workers)
                                                       : echoes_at_once(moment, workers);
  const Sonar& sonar = moment.session.sonar;
  const Water& water = moment.session.water;
  const std::vector<double> more_db_m = more_absorption_db_m(sonar, water);
  if (more_db_m.empty()) return echoes;
  absorb(echoes.scatterers, water, more_db_m);
  absorb(echoes.hidden.list, water, more_db_m);
  for (VolumeEcho& volume : echoes.volumes) absorb(volume, sonar, water, more_db_m);
  for (ElevationEcho& echo : echoes.volume_elevation) {
    const double path_m = 2 * sample_range_m(sonar, water, echo.sample);
    echo.diffuse_pa2 *= static_cast<float>(std::pow(10.0, -more_db_m[echo.beam] * path_m / 10));
  }
  return echoes;
}

EchoCounts count_echoes(const Moment& moment, const Workers& workers) {
  const Session& session = moment.session;
  const auto [hits, paths] = trace_fan(moment.tracer, moment.fan, moment.sonar_in_world,
                                       session.sonar, session.water, workers);
  EchoCounts count;
  count.surface = surface_echoes(moment, hits, paths, workers).size();
  const OtherEchoes other = other_echoes(moment, hits, workers);
  count.coherent = other.most;
  if (!moment.with_hidden) return count;
  count.hidden = trace_behind(moment.tracer, moment.fan, hits, moment.sonar_in_world, session.sonar,
                              session.water, workers)
                     .behind.hits.size() +
                 other.points.hidden.size();
  return count;
}

}  // namespace ensonify
