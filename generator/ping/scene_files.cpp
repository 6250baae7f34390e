#include "ping/scene_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <span>

#include "core/scatterers.h"
#include "ping/navigation_files.h"
#include "world/scene_sdf.h"

namespace ensonify {
namespace {

std::uint32_t pings_of(const Session& session) {
  return static_cast<std::uint32_t>(session.ping_times_s.size());
}

std::vector<Vec3> sonar_positions(const Session& session) {
  std::vector<Vec3> positions_m;
  for (std::uint32_t ping = 0; ping < pings_of(session); ++ping) {
    positions_m.push_back(sonar_pose(session, ping).position_m);
  }
  return positions_m;
}

// The box within range of the sonar in all pings of [first, last).
SdfRegion reach_of(const Session& session, std::uint32_t first_ping, std::uint32_t last_ping) {
  Bounds bounds;
  for (std::uint32_t ping = first_ping; ping < last_ping; ++ping) {
    bounds.add(sonar_pose(session, ping).position_m);
  }
  const double range = session.sonar.range_max_m;
  return {bounds.low - Vec3{range, range, range}, bounds.high + Vec3{range, range, range}};
}

Status check_sdf(const Session& session) {
  const std::optional<SdfGrid>& sdf = session.scenario.output.sdf;
  if (!sdf) return {};
  Status fits = sdf_fits(session.world, object_poses(session, 0), *sdf,
                         reach_of(session, 0, pings_of(session)));
  if (fits) return {};
  return Error{fits.error().kind, "output.sdf.voxel_m: " + fits.error().message};
}

Status check_meshes(const Session& session) {
  if (!session.scenario.output.selection.world) return {};
  Status fits = scene_fits(session.world);
  if (fits) return {};
  return Error{fits.error().kind, "output.world: " + fits.error().message};
}

// Directions whose ends at full range span the outline of a fan, seen from above.
std::vector<Vec3> outline_of(const Sonar& sonar) {
  constexpr int kAzimuths = 64, kElevations = 8;
  const std::vector<double> borders = beam_borders_rad(sonar);
  std::vector<Vec3> directions;
  for (int a = 0; a <= kAzimuths; ++a) {
    const double azimuth = std::lerp(borders.front(), borders.back(), double{1} * a / kAzimuths);
    for (int e = 0; e <= kElevations; ++e) {
      const double elevation = (double{1} * e / kElevations - 0.5) * sonar.elevation_fan_rad;
      directions.push_back(unit_vector(azimuth, elevation));
    }
  }
  return directions;
}

Bounds fan_bounds(const Session& session) {
  const std::vector<Vec3> outline = outline_of(session.sonar);
  Bounds bounds;
  for (std::uint32_t ping = 0; ping < pings_of(session); ++ping) {
    const Pose pose = sonar_pose(session, ping);
    bounds.add(pose.position_m);
    for (const Vec3& direction : outline) {
      bounds.add(transform_point(pose, session.sonar.range_max_m * direction));
    }
  }
  return bounds;
}

// The first and the last multiple of the spacing.
struct Multiples {
  double first = 0, last = 0;
  double count() const { return last - first + 1; }
};

Multiples multiples(double low_m, double high_m, double spacing_m) {
  return {std::floor(low_m / spacing_m), std::ceil(high_m / spacing_m)};
}

Status check_height_map(const Session& session) {
  const auto& map = session.scenario.output.height_map;
  if (!map) return {};
  const Bounds bounds = fan_bounds(session);
  const double points = multiples(bounds.low.x, bounds.high.x, map->spacing_m).count() *
                        multiples(bounds.low.y, bounds.high.y, map->spacing_m).count();
  if (points <= static_cast<double>(kMostHeights)) return {};
  return Error{
      ErrorKind::usage,
      fmt::format("output.height_map.spacing_m: gives {:.2g} points; expected {} at most: "
                  "use {:.2g} m or more",
                  points, kMostHeights,
                  1.05 * map->spacing_m * std::sqrt(points / static_cast<double>(kMostHeights)))};
}

// Of the boxes of all objects that have one; a ray from above it begins outside of them.
double highest_corner_m(const SequenceInfo& info, std::span<const Pose> objects) {
  double highest_m = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::optional<OrientedBox>& box = info.instances[i].box;
    if (!box) continue;
    for (int corner = 0; corner < 8; ++corner) {
      const auto half = [&](int axis, double size) { return (corner >> axis & 1 ? 0.5 : -0.5) * size; };
      const Vec3 own = transform_point(
          box->pose, {half(0, box->size_m.x), half(1, box->size_m.y), half(2, box->size_m.z)});
      highest_m = std::max(highest_m, transform_point(objects[i], own).z);
    }
  }
  return highest_m;
}

// The text of the headers, generously.
constexpr double kHeadBytesPerObject = 800;

void add_meshes(const Session& session, SceneFileSizes& sizes) {
  if (!session.scenario.output.selection.world) return;
  const SceneSize size = scene_size(session.world);
  const double heads = kHeadBytesPerObject * static_cast<double>(session.world.objects.size());
  sizes.file_bytes += static_cast<double>(size.ply_bytes + size.glb_bytes) + heads;
  // The header of the glTF file, as values and as text.
  sizes.memory_bytes += static_cast<double>(size.made_bytes) + 5 * heads;
}

}  // namespace

Status check_scene_files(const Session& session) {
  if (Status fits = check_sdf(session); !fits) return fits;
  if (Status fits = check_meshes(session); !fits) return fits;
  return check_height_map(session);
}

SceneFileSizes scene_file_sizes(const Session& session) {
  SceneFileSizes sizes;
  const OutputSpec& output = session.scenario.output;
  if (output.sdf && !session.world.objects.empty()) {
    const SdfSize sdf = sdf_size(session.world, object_poses(session, 0), *output.sdf,
                                 reach_of(session, 0, pings_of(session)));
    sizes = {sdf.file_bytes, sdf.memory_bytes};
  }
  add_meshes(session, sizes);
  sizes.file_bytes += navigation_bytes(session);
  if (output.height_map) {
    const HeightMap grid = height_map_grid(session);
    // The heights, and the same as a file.
    sizes.memory_bytes += 2.0 * sizeof(float) * grid.rows * grid.columns;
  }
  return sizes;
}

Result<std::string> scene_sdf(const Session& session, const SequenceInfo& info) {
  if (!info.sdf) return std::string();
  Result<std::string> sdf =
      scene_sdf_vdb(session.world, object_poses(session, info.first_ping), *info.sdf,
                    reach_of(session, info.first_ping, info.last_ping));
  if (!sdf) return Error{sdf.error().kind, "output.sdf: " + sdf.error().message};
  return sdf;
}

std::vector<SceneObject> scene_meshes(const Session& session, const SequenceInfo& info) {
  if (!info.output.world) return {};
  return scene_objects(session.world, object_poses(session, info.first_ping),
                       {sonar_positions(session), session.sonar.range_max_m});
}

HeightMap height_map_grid(const Session& session) {
  HeightMap map;
  map.spacing_m = session.scenario.output.height_map->spacing_m;
  const Bounds bounds = fan_bounds(session);
  const Multiples x = multiples(bounds.low.x, bounds.high.x, map.spacing_m);
  const Multiples y = multiples(bounds.low.y, bounds.high.y, map.spacing_m);
  // Without check_scene_files, as for a sweep's cost, there may be more.
  const auto side = [](double count) {
    return static_cast<int>(std::min(count, static_cast<double>(kMostHeights)));
  };
  map.rows = side(y.count());
  map.columns = side(x.count());
  map.x_west_m = x.first * map.spacing_m;
  map.y_north_m = y.last * map.spacing_m;
  return map;
}

Result<std::vector<float>> scene_heights(const Session& session, const Tracer& tracer,
                                         const SequenceInfo& info, const Workers& workers,
                                         const std::function<Status()>& go_on) {
  if (!info.height_map) return std::vector<float>();
  const HeightMap& map = *info.height_map;
  const double range_m = session.sonar.range_max_m;
  Bounds sonars;
  for (const Vec3& position_m : sonar_positions(session)) sonars.add(position_m);
  const std::vector<Pose> objects = object_poses(session, info.first_ping);
  const double top_m = std::max(sonars.high.z + range_m, highest_corner_m(info, objects) + 1);
  const double depth_m = top_m - (sonars.low.z - range_m);
  const Tracer scene = tracer.at(objects);
  const auto columns = static_cast<std::size_t>(map.columns);
  std::vector<float> heights_m(static_cast<std::size_t>(map.rows) * columns,
                               std::numeric_limits<float>::quiet_NaN());
  std::mutex mutex;
  Status status;
  workers.for_each(static_cast<std::size_t>(map.rows), [&](std::size_t row) {
    {
      const std::scoped_lock lock(mutex);
      if (status) status = go_on();
      if (!status) return;
    }
    const double y_m = map.y_north_m - static_cast<double>(row) * map.spacing_m;
    for (std::size_t column = 0; column < columns; ++column) {
      const double x_m = map.x_west_m + static_cast<double>(column) * map.spacing_m;
      const Hit hit = scene.first_hit({{x_m, y_m, top_m}, {0, 0, -1}}, depth_m);
      if (hit.instance == 0) continue;
      heights_m[row * columns + column] = static_cast<float>(top_m - hit.range_m);
    }
  });
  if (!status) return status.error();
  return heights_m;
}

}  // namespace ensonify
