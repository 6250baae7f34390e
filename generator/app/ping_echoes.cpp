#include "app/ping_echoes.h"

#include <utility>

#include "app/motion.h"
#include "trace/bent.h"
#include "trace/by_need.h"
#include "trace/hidden.h"
#include "trace/kirchhoff.h"
#include "trace/multipath.h"
#include "trace/surface_points.h"
#include "trace/volume.h"

namespace ensonify {
namespace {

void add_bounced(const Moment& moment, const std::vector<Hit>& hits, const Workers& workers,
                 std::vector<Scatterer>& more) {
  const Session& session = moment.session;
  if (session.bounces.paths.empty()) return;
  const std::vector<Pose> objects = object_poses(session, moment.ping);
  std::vector<Scatterer> bounced =
      bounced_echoes({session.bounces, session.world, moment.tracer, objects, moment.sonar_in_world,
                      moment.scattering},
                     moment.fan, hits, workers);
  // What moves makes them two: an element's places in the water at their two arrivals differ.
  const bool same = !session.sonar.array && !moves(session);
  if (same) bounced = both_ways_as_one(std::move(bounced));
  more.insert(more.end(), bounced.begin(), bounced.end());
}

PointScatterers point_scatterers(const Moment& moment, const Workers& workers) {
  const auto& [session, fan, scattering, tracer, ping, pose, wants_hidden, speckle_key] = moment;
  PointScatterers points;
  std::vector<HiddenTarget>* hidden = wants_hidden ? &points.hidden : nullptr;
  points.heard =
      point_target_scatterers(session.world, tracer, pose, session.sonar, session.water, hidden);
  const std::vector<Scatterer> fish =
      school_scatterers(session.world, tracer, pose, session.sonar, session.water, workers, hidden);
  points.heard.insert(points.heard.end(), fish.begin(), fish.end());
  return points;
}

// Of surfaces: those fixed on them, or one a ray.
ScattererList surface_echoes(const Moment& moment, std::span<const Hit> hits,
                             std::span<const RayPath> paths, const Workers& workers) {
  const auto& [session, fan, scattering, tracer, ping, pose, wants_hidden, speckle_key] = moment;
  if (const std::optional<SurfaceTiles>& tiles = session.surface_tiles) {
    return surface_point_list(*tiles, tracer, object_poses(session, ping), pose, scattering,
                              speckle_key, workers);
  }
  if (session.sonar.rays_per_cell == 0) {
    return surface_scatterer_list(fan, hits, scattering, workers, paths);
  }
  const auto pieces = pieces_by_need(session.sonar, session.cell, fan, hits, pose);
  return surface_scatterers_by_need(fan, {hits, paths}, pieces, tracer, pose, scattering, workers);
}

// With everything where it is when the ping goes out.
PingEchoes echoes_at_rest(const Moment& moment, const Workers& workers) {
  const auto& [session, fan, scattering, tracer, ping, pose, wants_hidden, speckle_key] = moment;
  const auto [hits, paths] = trace_fan(tracer, fan, pose, session.sonar, session.water, workers);
  std::vector<Scatterer> more = kirchhoff_scatterers(fan, hits, tracer, pose, scattering, workers);
  const PointScatterers points = point_scatterers(moment, workers);
  more.insert(more.end(), points.heard.begin(), points.heard.end());
  add_bounced(moment, hits, workers, more);
  PingEchoes echoes;
  echoes.scatterers = with_more(surface_echoes(moment, hits, paths, workers), more, workers);
  attenuate(echoes.scatterers, session.world.volumes, pose, session.sonar, session.water, workers);
  echoes.volumes = volume_echoes(fan, hits, session.world.volumes, pose, session.sonar,
                                 session.water, session.record, workers);
  if (!wants_hidden) return echoes;
  const FanHitsBehind behind =
      trace_behind(tracer, fan, hits, pose, session.sonar, session.water, workers);
  echoes.hidden =
      hidden_echoes(fan, hits, behind, points, scattering, session.world.instances.size(), workers);
  attenuate(echoes.hidden.list, session.world.volumes, pose, session.sonar, session.water, workers);
  return echoes;
}

}  // namespace

PingEchoes ping_echoes(const Moment& moment, const Workers& workers) {
  PingEchoes echoes = echoes_at_rest(moment, workers);
  move(moment, workers, echoes);
  return echoes;
}

}  // namespace ensonify
