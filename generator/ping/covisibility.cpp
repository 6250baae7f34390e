#include "ping/covisibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "trace/echo_points.h"

namespace ensonify {
namespace {

constexpr int kColumns = kCovisibilityColumns, kRows = kCovisibilityRows;

// What a ping sees.
struct View {
  std::vector<Vec3> in_object_m;
  std::vector<std::uint32_t> object;  // index into World::objects
  std::vector<double> weight;         // of the solid angle
  double whole = 0;                   // sum of the weights
};

View view_of(const Session& session, const Tracer& resting, std::uint32_t ping) {
  const Sonar& sonar = session.sonar;
  const std::vector<Pose> objects = object_poses(session, ping);
  const Pose pose = sonar_pose(session, ping);
  const std::vector<double> borders = beam_borders_rad(sonar);
  const double width = borders.back() - borders.front();
  std::vector<Vec3> directions;
  std::vector<double> weights;
  for (int c = 0; c < kColumns; ++c) {
    for (int r = 0; r < kRows; ++r) {
      const double azimuth = borders.front() + (c + 0.5) * width / kColumns;
      const double elevation = ((r + 0.5) / kRows - 0.5) * sonar.elevation_fan_rad;
      directions.push_back(rotate(pose.rotation, unit_vector(azimuth, elevation)));
      weights.push_back(std::cos(elevation));
    }
  }
  std::vector<Hit> hits(directions.size());
  resting.at(objects).first_hits(pose.position_m, directions, sonar.range_max_m, hits);
  View view;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].instance == 0 || hits[i].range_m < sonar.range_min_m) continue;
    const std::uint32_t object = hits[i].instance - 1;
    const Vec3 point_m = pose.position_m + hits[i].range_m * directions[i];
    view.in_object_m.push_back(inverse_transform_point(objects[object], point_m));
    view.object.push_back(object);
    view.weight.push_back(weights[i]);
    view.whole += weights[i];
  }
  return view;
}

float share_seen(const View& view, const Viewpoint& from, std::span<const Pose> objects) {
  if (view.object.empty()) return std::numeric_limits<float>::quiet_NaN();
  std::vector<Vec3> points_m;
  for (std::size_t i = 0; i < view.object.size(); ++i) {
    points_m.push_back(transform_point(objects[view.object[i]], view.in_object_m[i]));
  }
  std::vector<PointSight> sights(points_m.size());
  see_points(from, points_m, sights);
  double seen = 0;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    if (sights[i].state == PointState::seen) seen += view.weight[i];
  }
  return static_cast<float>(seen / view.whole);
}

}  // namespace

Status check_covisibility(const Session& session) {
  const std::size_t pings = session.ping_times_s.size();
  if (!session.scenario.output.selection.covisibility || pings <= kMostCovisiblePings) return {};
  return Error{ErrorKind::usage,
               fmt::format("output.covisibility: the sequence has {} pings; expected {} at most",
                           pings, kMostCovisiblePings)};
}

Result<std::vector<float>> covisibility(const Session& session, const Tracer& tracer,
                                        const SequenceInfo& info, const Workers& workers,
                                        const std::function<Status()>& go_on) {
  const std::size_t pings = info.last_ping - info.first_ping;
  const auto number = [&](std::size_t i) { return info.first_ping + static_cast<std::uint32_t>(i); };
  std::vector<View> views(pings);
  workers.for_each(pings, [&](std::size_t a) { views[a] = view_of(session, tracer, number(a)); });
  std::vector<float> shares(pings * pings);
  std::mutex mutex;
  Status status;
  workers.for_each(pings, [&](std::size_t b) {
    {
      const std::scoped_lock lock(mutex);
      if (status) status = go_on();
      if (!status) return;
    }
    const std::vector<Pose> objects = object_poses(session, number(b));
    const Tracer there = tracer.at(objects);
    const Viewpoint from{there, session.sonar, sonar_pose(session, number(b))};
    for (std::size_t a = 0; a < pings; ++a) {
      shares[a * pings + b] = share_seen(views[a], from, objects);
    }
  });
  if (!status) return status.error();
  return shares;
}

std::uint64_t covisibility_bytes(const OutputSelection& output, std::uint64_t pings) {
  if (!output.covisibility) return 0;
  constexpr std::uint64_t kPoint = sizeof(Vec3) + sizeof(std::uint32_t) + sizeof(double);
  // The matrix, and its bytes as a file.
  return pings * (2 * pings * sizeof(float) + kColumns * kRows * kPoint);
}

}  // namespace ensonify
