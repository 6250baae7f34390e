#include "trace/surface_points.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "core/random.h"

namespace ensonify {
namespace {

// Largest ratio of a tile's radius to its distance, so that one size of leaves suits all of it.
constexpr double kTileSize = 0.25;
// The same where leaves follow the pattern, which continues from tile to tile, so that more of them
// cost nothing but their number.
constexpr double kEvenTileSize = 0.1;
// Parts are cut in parallel as soon as there are this many.
constexpr std::size_t kJobs = 64;
// Leaves are counted in parts of one: small triangles hold few places of the pattern.
constexpr double kCountedParts = 1024;
// Surfaces that are tilted further than this cosine from the pattern's plane do not follow it.
// Those less tilted than the other one share a scale, since it changes in steps.
constexpr double kSteepest = 0.5, kNearlyFlat = 0.9;

// Undivided surfaces of an object: the triangles of a mesh, the faces of a body, squares of a
// plane.
struct Primitives {
  const Mesh* mesh = nullptr;
  std::vector<Patch> patches;         // of other shapes
  std::vector<std::uint64_t> number;  // of other shapes: index among those of the object
  std::vector<Ball> balls;

  Patch patch(std::uint32_t i) const {
    if (mesh == nullptr) return patches[i];
    const auto corner = [&](int k) {
      const auto& v = mesh->vertices[mesh->triangles[i][k]];
      return Vec3{v[0], v[1], v[2]};
    };
    return TrianglePatch{corner(0), corner(1), corner(2)};
  }
  std::uint64_t number_of(std::uint32_t i) const { return mesh == nullptr ? number[i] : i; }
};

Ball ball_around(const Patch& patch) {
  return std::visit([](const auto& p) { return ball_of(p); }, patch);
}

void add(Primitives& all, const Patch& patch, std::uint64_t number) {
  all.patches.push_back(patch);
  all.number.push_back(number);
}

template <class Body>
void add_primitives(Primitives& all, const Body& body) {
  for (const Patch& patch : surface_patches(body)) add(all, patch, all.number.size());
}

void add_primitives(Primitives& all, const MeshShape& mesh) { all.mesh = mesh.mesh.get(); }

// Squares of a plane, on a grid as wide as the largest range, rounded up to a power of two.
void add_plane(Primitives& all, double range_max_m, std::span<const Pose> eyes) {
  const double side = std::exp2(std::ceil(std::log2(range_max_m)));
  std::set<std::pair<std::int32_t, std::int32_t>> squares;
  for (const Pose& eye : eyes) {
    const Vec3 p = eye.position_m;
    if (std::abs(p.z) > range_max_m) continue;
    const auto at = [&](double x) { return static_cast<std::int32_t>(std::floor(x / side)); };
    for (std::int32_t i = at(p.x - range_max_m); i <= at(p.x + range_max_m); ++i) {
      for (std::int32_t j = at(p.y - range_max_m); j <= at(p.y + range_max_m); ++j) {
        squares.insert({i, j});
      }
    }
  }
  for (const auto& [i, j] : squares) {
    const std::uint64_t number =
        std::uint64_t{static_cast<std::uint32_t>(i)} << 32 | static_cast<std::uint32_t>(j);
    add(all, RectanglePatch{{i * side, j * side, 0}, {side, 0, 0}, {0, side, 0}}, number);
  }
}

Primitives primitives_of(const Shape& shape, double range_max_m, std::span<const Pose> eyes) {
  Primitives all;
  std::visit(
      [&](const auto& s) {
        if constexpr (std::is_same_v<std::decay_t<decltype(s)>, PlaneShape>) {
          add_plane(all, range_max_m, eyes);
        } else {
          add_primitives(all, s);
        }
      },
      shape);
  const std::size_t count = all.mesh ? all.mesh->triangles.size() : all.patches.size();
  for (std::uint32_t i = 0; i < count; ++i) all.balls.push_back(ball_around(all.patch(i)));
  return all;
}

// Primitives, or a part of one, that must still be cut, and the eyes that may see them.
struct TilePiece {
  std::uint32_t begin = 0, end = 0;  // in Cutter::order; one entry: a part of this primitive
  std::uint64_t path = 0;            // 0: whole primitives
  Patch patch;
  std::vector<std::uint32_t> eyes;
};

// Cuts the surfaces of one object.
struct Cutter {
  const SurfaceViews& views;
  std::uint32_t object = 0;
  std::uint64_t object_key = 0;
  std::vector<Pose> eyes;  // no two equal ones in a row
  Primitives primitives;
  std::vector<std::uint32_t> order;  // of primitives, reordered while they are grouped
  // By eye, in the tiles that it may hear, times kCountedParts.
  std::unique_ptr<std::atomic<std::uint64_t>[]> leaves;
  bool is_even = false;  // whether its surfaces follow the pattern
};

// Ground and rooms with flat walls: their edges are few. The constant part of rician materials
// depends on the number of scatterers.
bool is_even(const WorldObject& object) {
  const auto* mesh = std::get_if<MeshShape>(&object.shape);
  const auto* box = std::get_if<BoxShape>(&object.shape);
  const bool is_flat = std::holds_alternative<PlaneShape>(object.shape) ||
                       (mesh != nullptr && mesh->ground) || (box != nullptr && box->inside);
  const auto fits = [](const Material& m) { return m.coherent != CoherentModel::rician; };
  return is_flat && fits(object.material) && std::ranges::all_of(object.parts.materials, fits);
}

// The plane of a patch that may follow the pattern: terrain is seen from above.
std::optional<EvenPlane> plane_of(const Patch& patch) {
  if (const auto* rectangle = std::get_if<RectanglePatch>(&patch)) return even_plane(*rectangle);
  const auto* triangle = std::get_if<TrianglePatch>(&patch);
  if (triangle == nullptr) return std::nullopt;
  constexpr int kUp = 2;
  const Vec3 normal = normalized(cross(triangle->b - triangle->a, triangle->c - triangle->a));
  if (!(std::abs(normal.z) >= kSteepest)) return std::nullopt;
  return even_plane(*triangle, kUp);
}

Ball ball_of(const Cutter& cutter, const TilePiece& piece) {
  if (piece.path != 0) return ball_around(piece.patch);
  Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high = -low;
  for (std::uint32_t i = piece.begin; i < piece.end; ++i) {
    const auto& [c, r] = cutter.primitives.balls[cutter.order[i]];
    low = {std::min(low.x, c.x - r), std::min(low.y, c.y - r), std::min(low.z, c.z - r)};
    high = {std::max(high.x, c.x + r), std::max(high.y, c.y + r), std::max(high.z, c.z + r)};
  }
  return {0.5 * (low + high), 0.5 * length(high - low)};
}

// Keeps the eyes that may hear the ball, and returns the least range of all.
double keep_eyes(const Cutter& cutter, const Ball& ball, std::vector<std::uint32_t>& eyes) {
  double nearest = HUGE_VAL;
  std::erase_if(eyes, [&](std::uint32_t eye) {
    const Vec3 centre = inverse_transform_point(cutter.eyes[eye], ball.centre_m);
    const auto range = nearest_in_fan(cutter.views.sonar, {centre, ball.radius_m});
    if (range) nearest = std::min(nearest, *range);
    return !range;
  });
  // The sonar resolves nothing within the length of its pulse.
  return std::max(nearest, cutter.views.resolution_m);
}

// Both return the number of leaves.
double follow_pattern(const Cutter& cutter, const EvenPlane& plane, double area_m2,
                      double nearest_m, SurfaceTile& tile) {
  const double cosine = 1 / plane.stretch();
  const double wanted =
      even_leaf_area_m2(cutter.views, nearest_m) * (cosine == 1             ? 1
                                                    : cosine >= kNearlyFlat ? kNearlyFlat
                                                                            : kSteepest);
  tile.axis = plane.axis;
  tile.scale = even_scale(std::sqrt(wanted));
  const double spacing_m = even_spacing_of(tile.scale);
  return area_m2 * cosine / (spacing_m * spacing_m);
}

double halve(const Cutter& cutter, double area_m2, double nearest_m, SurfaceTile& tile) {
  const double wanted = leaf_area_m2(cutter.views, nearest_m);
  // The bits of a path limit the depth.
  const int deepest = std::countl_zero(tile.path) - 1;
  while (area_m2 > wanted && static_cast<int>(tile.levels) < deepest) {
    area_m2 /= 2;
    ++tile.levels;
  }
  return std::ldexp(1.0, static_cast<int>(tile.levels));
}

void add_tile(const Cutter& cutter, TilePiece& piece, const Ball& ball, double nearest_m,
              std::vector<SurfaceTile>& tiles) {
  SurfaceTile tile{piece.patch, ball, cutter.object, 0, 0, piece.path};
  const std::uint32_t primitive = cutter.order[piece.begin];
  tile.root = mix64(cutter.object_key ^ mix64(~cutter.primitives.number_of(primitive)));
  const double area = std::visit([](const auto& p) { return area_m2(p); }, piece.patch);
  const std::optional<EvenPlane> plane =
      cutter.is_even ? plane_of(piece.patch) : std::optional<EvenPlane>();
  const double leaves = plane ? follow_pattern(cutter, *plane, area, nearest_m, tile)
                              : halve(cutter, area, nearest_m, tile);
  for (const std::uint32_t eye : piece.eyes) {
    cutter.leaves[eye].fetch_add(static_cast<std::uint64_t>(std::ceil(kCountedParts * leaves)),
                                 std::memory_order_relaxed);
  }
  tiles.push_back(std::move(tile));
}

// Splits a group of primitives in two along the axis on which their middles are spread most.
void part_group(Cutter& cutter, TilePiece& piece, const Ball& around,
                std::vector<TilePiece>& rest) {
  const auto first = cutter.order.begin() + piece.begin, last = cutter.order.begin() + piece.end;
  Vec3 spread{};
  for (auto i = first; i != last; ++i) {
    const Vec3 d = cutter.primitives.balls[*i].centre_m - around.centre_m;
    spread = {std::max(spread.x, std::abs(d.x)), std::max(spread.y, std::abs(d.y)),
              std::max(spread.z, std::abs(d.z))};
  }
  const auto along = [&](std::uint32_t i) {
    const Vec3 c = cutter.primitives.balls[i].centre_m;
    if (spread.x >= spread.y && spread.x >= spread.z) return c.x;
    return spread.y >= spread.z ? c.y : c.z;
  };
  const std::uint32_t middle = piece.begin + (piece.end - piece.begin) / 2;
  std::nth_element(first, cutter.order.begin() + middle, last,
                   [&](std::uint32_t a, std::uint32_t b) {
                     return std::pair(along(a), a) < std::pair(along(b), b);
                   });
  TilePiece second{middle, piece.end, 0, {}, piece.eyes};
  rest.push_back({piece.begin, middle, 0, {}, std::move(piece.eyes)});
  rest.push_back(std::move(second));
}

// Turns a piece into a tile or replaces it by two pieces, and drops a piece that no eye may hear.
void cut(Cutter& cutter, TilePiece piece, std::vector<TilePiece>& rest,
         std::vector<SurfaceTile>& tiles) {
  if (piece.path == 0 && piece.end == piece.begin + 1) {
    piece.path = 1;
    piece.patch = cutter.primitives.patch(cutter.order[piece.begin]);
  }
  const Ball ball = ball_of(cutter, piece);
  const double nearest = keep_eyes(cutter, ball, piece.eyes);
  if (piece.eyes.empty()) return;
  if (piece.path == 0) return part_group(cutter, piece, ball, rest);
  const double size = cutter.is_even ? kEvenTileSize : kTileSize;
  if (ball.radius_m <= size * nearest || std::countl_zero(piece.path) <= 2) {
    return add_tile(cutter, piece, ball, nearest, tiles);
  }
  std::visit(
      [&](const auto& whole) {
        const auto halves = halves_of(whole);
        rest.push_back({piece.begin, piece.end, 2 * piece.path, halves[0], piece.eyes});
        rest.push_back(
            {piece.begin, piece.end, 2 * piece.path + 1, halves[1], std::move(piece.eyes)});
      },
      piece.patch);
}

// Collects the eyes, merging equal ones in a row, and returns the index of each ping's eye.
std::vector<std::uint32_t> part_eyes(std::span<const Pose> by_ping, std::vector<Pose>& eyes) {
  std::vector<std::uint32_t> of_ping;
  for (const Pose& pose : by_ping) {
    if (eyes.empty() || !(eyes.back() == pose)) eyes.push_back(pose);
    of_ping.push_back(static_cast<std::uint32_t>(eyes.size() - 1));
  }
  return of_ping;
}

void cut_object(Cutter& cutter, const Workers& workers, std::vector<SurfaceTile>& tiles) {
  if (cutter.primitives.balls.empty()) return;
  cutter.order.resize(cutter.primitives.balls.size());
  std::iota(cutter.order.begin(), cutter.order.end(), 0u);
  std::vector<std::uint32_t> all(cutter.eyes.size());
  std::iota(all.begin(), all.end(), 0u);
  std::vector<TilePiece> jobs, next;
  jobs.push_back({0, static_cast<std::uint32_t>(cutter.order.size()), 0, {}, std::move(all)});
  // Cuts breadth first until there are enough jobs for all workers, then each job depth first.
  while (!jobs.empty() && jobs.size() < kJobs) {
    for (TilePiece& job : jobs) cut(cutter, std::move(job), next, tiles);
    jobs = std::exchange(next, {});
  }
  std::vector<std::vector<SurfaceTile>> made(jobs.size());
  workers.for_each(jobs.size(), [&](std::size_t i) {
    std::vector<TilePiece> rest;
    rest.push_back(std::move(jobs[i]));
    while (!rest.empty()) {
      TilePiece piece = std::move(rest.back());
      rest.pop_back();
      cut(cutter, std::move(piece), rest, made[i]);
    }
  });
  for (auto& part : made) tiles.insert(tiles.end(), part.begin(), part.end());
}

// Objects without a name, which only tests have, are distinguished by their order.
std::uint64_t key_of(const World& world, const WorldObject& object,
                     std::map<std::string, std::uint64_t>& seen) {
  const std::size_t i = object.instance - 1;
  const std::string name = i < world.instances.size() ? world.instances[i].name : std::string();
  return mix64(name_key(name) + seen[name]++);
}

}  // namespace

Pose pose_in(const Pose& object_in_world, const Pose& sonar_in_world) {
  return {inverse_transform_point(object_in_world, sonar_in_world.position_m),
          conjugate(object_in_world.rotation) * sonar_in_world.rotation};
}

std::uint64_t leaf_key(std::uint64_t root, std::uint64_t path) {
  // Its highest bits mark the keys of point targets and kirchhoff_scatterers.
  return mix64(root ^ path) >> 2;
}

namespace {

// Of the smallest -3 dB cell of beam and pulse.
struct SmallestCell {
  double width_m = 0, high_m = 0;
};

SmallestCell smallest_cell(const SurfaceViews& views, double range_m) {
  const Sonar& sonar = views.sonar;
  const double high = range_m * std::min(sonar.elevation_width_rad, sonar.elevation_fan_rad);
  double width = sonar.beam_width_rad;
  for (const double narrow : sonar.width_rad) width = std::min(width, narrow);
  return {range_m * width, std::min(views.resolution_m, high)};
}

}  // namespace

double leaf_area_m2(const SurfaceViews& views, double range_m) {
  const auto [width, high] = smallest_cell(views, range_m);
  return width * high /
         std::max(kScatterersPerCell, static_cast<double>(views.sonar.rays_per_cell.value_or(0)));
}

double even_leaf_area_m2(const SurfaceViews& views, double range_m) {
  const auto [width, high] = smallest_cell(views, range_m);
  const double spacing = views.even.at(width) * high / views.resolution_m;
  const double area = std::max(spacing * spacing, width * high / kEvenScatterersPerCell);
  const int asked = views.sonar.rays_per_cell.value_or(0);
  return asked > 0 ? std::min(area, width * high / asked) : area;
}

namespace {

// The part of a ball around `p` that lies in the angles of the fan, whatever its range.
FanPart part_in_angles(const Sonar& sonar, Vec3 p, double range, double reach) {
  if (range <= reach) return FanPart::some;
  // Allows for rounding.
  constexpr double kSlack = 1e-9;
  const double sine = std::min(1.0, reach / range), apart = std::asin(sine) + kSlack;
  const double elevation = std::abs(std::asin(std::clamp(p.z / range, -1.0, 1.0)));
  if (elevation > sonar.elevation_fan_rad / 2 + apart) return FanPart::none;
  const double cosine = std::cos(elevation);
  if (cosine <= sine) return FanPart::some;
  const double aside = std::asin(sine / cosine) + kSlack, azimuth = std::abs(std::atan2(p.y, p.x));
  if (azimuth > furthest_azimuth_rad(sonar) + aside) return FanPart::none;
  const bool is_inside = elevation + apart < sonar.elevation_fan_rad / 2 &&
                         azimuth + aside < furthest_azimuth_rad(sonar);
  return is_inside ? FanPart::all : FanPart::some;
}

}  // namespace

FanPart part_in_fan(const Sonar& sonar, const Ball& ball) {
  const double range = length(ball.centre_m), reach = ball.radius_m;
  if (range - reach > sonar.range_max_m || range + reach < sonar.range_min_m) return FanPart::none;
  const FanPart part = part_in_angles(sonar, ball.centre_m, range, reach);
  const bool is_near = range + reach<sonar.range_max_m, is_far = range - reach> sonar.range_min_m;
  return part == FanPart::all && !(is_near && is_far) ? FanPart::some : part;
}

std::optional<double> nearest_in_fan(const Sonar& sonar, const Ball& ball) {
  if (part_in_fan(sonar, ball) == FanPart::none) return std::nullopt;
  return std::max(length(ball.centre_m) - ball.radius_m, sonar.range_min_m);
}

SurfaceTiles surface_tiles(const World& world, const SurfaceViews& views, const Workers& workers) {
  SurfaceTiles result;
  std::vector<std::uint64_t> leaves;
  std::map<std::string, std::uint64_t> seen;
  for (std::uint32_t i = 0; i < world.objects.size(); ++i) {
    Cutter cutter{views, i, key_of(world, world.objects[i], seen), {}, {}, {}, {}, {}};
    cutter.is_even = !views.even.spacing_m.empty() && is_even(world.objects[i]);
    const std::vector<std::uint32_t> eye_of_ping = part_eyes(views.sonar_in_object(i), cutter.eyes);
    cutter.leaves = std::make_unique<std::atomic<std::uint64_t>[]>(cutter.eyes.size());
    cutter.primitives = primitives_of(world.objects[i].shape, views.sonar.range_max_m, cutter.eyes);
    cut_object(cutter, workers, result.tiles);
    result.instance.push_back(world.objects[i].instance);
    leaves.resize(eye_of_ping.size());
    for (std::size_t ping = 0; ping < leaves.size(); ++ping) {
      leaves[ping] += cutter.leaves[eye_of_ping[ping]];
    }
  }
  for (const std::uint64_t count : leaves) {
    result.most_leaves =
        std::max(result.most_leaves,
                 static_cast<std::uint64_t>(std::ceil(static_cast<double>(count) / kCountedParts)));
  }
  return result;
}

}  // namespace ensonify
