#include "app/ping_echoes.h"

#include <utility>

#include "trace/hidden.h"
#include "trace/kirchhoff.h"
#include "trace/multipath.h"
#include "trace/volume.h"

namespace ensonify {
namespace {

void add_bounced(const Moment& moment, const std::vector<Hit>& hits, const Workers& workers,
                 std::vector<Scatterer>& more) {
  const Session& session = moment.session;
  if (session.bounces.paths.empty()) return;
  const std::vector<Pose> objects = object_poses(session, moment.ping);
  const std::vector<Scatterer> bounced =
      bounced_echoes({session.bounces, session.world, moment.tracer, objects, moment.sonar_in_world,
                      moment.scattering},
                     moment.fan, hits, workers);
  more.insert(more.end(), bounced.begin(), bounced.end());
}

PointScatterers point_scatterers(const Moment& moment, const Workers& workers) {
  const auto& [session, fan, scattering, tracer, ping, pose, wants_hidden] = moment;
  PointScatterers points;
  std::vector<HiddenTarget>* hidden = wants_hidden ? &points.hidden : nullptr;
  points.heard =
      point_target_scatterers(session.world, tracer, pose, session.sonar, session.water, hidden);
  const std::vector<Scatterer> fish =
      school_scatterers(session.world, tracer, pose, session.sonar, session.water, workers, hidden);
  points.heard.insert(points.heard.end(), fish.begin(), fish.end());
  return points;
}

}  // namespace

PingEchoes ping_echoes(const Moment& moment, const Workers& workers) {
  const auto& [session, fan, scattering, tracer, ping, pose, wants_hidden] = moment;
  const double range_max_m = session.sonar.range_max_m;
  const std::vector<Hit> hits = tracer.trace_fan(fan, pose, range_max_m, workers);
  std::vector<Scatterer> more = kirchhoff_scatterers(fan, hits, tracer, pose, scattering, workers);
  const PointScatterers points = point_scatterers(moment, workers);
  more.insert(more.end(), points.heard.begin(), points.heard.end());
  add_bounced(moment, hits, workers, more);
  PingEchoes echoes;
  echoes.scatterers =
      with_more(surface_scatterer_list(fan, hits, scattering, workers), more, workers);
  attenuate(echoes.scatterers, session.world.volumes, pose, session.sonar, session.water, workers);
  echoes.volumes = volume_echoes(fan, hits, session.world.volumes, pose, session.sonar,
                                 session.water, session.record, workers);
  if (!wants_hidden) return echoes;
  const HitsBehind behind = tracer.trace_behind(fan, hits, pose, range_max_m, workers);
  echoes.hidden =
      hidden_echoes(fan, hits, behind, points, scattering, session.world.instances.size(), workers);
  attenuate(echoes.hidden.list, session.world.volumes, pose, session.sonar, session.water, workers);
  return echoes;
}

}  // namespace ensonify
