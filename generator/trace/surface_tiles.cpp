#include "trace/surface_points.h"

#include <algorithm>
#include <array>
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

#include "core/error.h"
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

// A pose of one of the sonars.
struct Eye {
  Pose pose;
  std::uint32_t view = 0;
};

// Squares of a plane, on a grid as wide as the largest range, rounded up to a power of two.
void add_plane(Primitives& all, double range_max_m, std::span<const Eye> eyes) {
  const double side = std::exp2(std::ceil(std::log2(range_max_m)));
  std::set<std::pair<std::int32_t, std::int32_t>> squares;
  for (const Eye& eye : eyes) {
    const Vec3 p = eye.pose.position_m;
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

Primitives primitives_of(const Shape& shape, double range_max_m, std::span<const Eye> eyes) {
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
  const std::vector<SurfaceViews>& views;
  std::uint32_t object = 0;
  std::uint64_t object_key = 0;
  std::vector<Eye> eyes;  // no two equal ones of a sonar in a row
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

// By sonar: the least range at which it may hear something; infinite if it does not.
using Nearest = std::array<double, kMostViews>;

double least(const Nearest& nearest) { return *std::ranges::min_element(nearest); }

// Keeps the eyes that may hear the ball, and returns their least ranges.
Nearest keep_eyes(const Cutter& cutter, const Ball& ball, std::vector<std::uint32_t>& eyes) {
  Nearest nearest;
  nearest.fill(HUGE_VAL);
  std::erase_if(eyes, [&](std::uint32_t i) {
    const Eye& eye = cutter.eyes[i];
    const SurfaceViews& views = cutter.views[eye.view];
    const Vec3 centre = inverse_transform_point(eye.pose, ball.centre_m);
    const auto range = nearest_in_fan(views.sonar, {centre, ball.radius_m});
    // The sonar resolves nothing within the length of its pulse.
    if (range) {
      nearest[eye.view] = std::min(nearest[eye.view], std::max(*range, views.resolution_m));
    }
    return !range;
  });
  return nearest;
}

// The least area that a sonar wants at its least range.
template <class AreaAt>
double least_area_m2(const Cutter& cutter, const Nearest& nearest, AreaAt area_at) {
  double area = HUGE_VAL;
  for (std::size_t view = 0; view < cutter.views.size(); ++view) {
    if (nearest[view] < HUGE_VAL) {
      area = std::min(area, area_at(cutter.views[view], nearest[view]));
    }
  }
  return area;
}

// Both return the number of leaves.
double follow_pattern(const Cutter& cutter, const EvenPlane& plane, double area_m2,
                      const Nearest& nearest, SurfaceTile& tile) {
  const double cosine = 1 / plane.stretch();
  const double wanted =
      least_area_m2(cutter, nearest, even_leaf_area_m2) * (cosine == 1             ? 1
                                                           : cosine >= kNearlyFlat ? kNearlyFlat
                                                                                   : kSteepest);
  tile.axis = plane.axis;
  tile.scale = even_scale(std::sqrt(wanted));
  const double spacing_m = even_spacing_of(tile.scale);
  return area_m2 * cosine / (spacing_m * spacing_m);
}

double halve(const Cutter& cutter, double area_m2, const Nearest& nearest, SurfaceTile& tile) {
  const double wanted = least_area_m2(cutter, nearest, leaf_area_m2);
  // The bits of a path limit the depth.
  const int deepest = std::countl_zero(tile.path) - 1;
  while (area_m2 > wanted && static_cast<int>(tile.levels) < deepest) {
    area_m2 /= 2;
    ++tile.levels;
  }
  return std::ldexp(1.0, static_cast<int>(tile.levels));
}

void add_tile(const Cutter& cutter, TilePiece& piece, const Ball& ball, const Nearest& nearest,
              std::vector<SurfaceTile>& tiles) {
  SurfaceTile tile{piece.patch, ball, cutter.object, 0, 0, piece.path};
  const std::uint32_t primitive = cutter.order[piece.begin];
  tile.root = mix64(cutter.object_key ^ mix64(~cutter.primitives.number_of(primitive)));
  const double area = std::visit([](const auto& p) { return area_m2(p); }, piece.patch);
  const std::optional<EvenPlane> plane =
      cutter.is_even ? plane_of(piece.patch) : std::optional<EvenPlane>();
  const double leaves = plane ? follow_pattern(cutter, *plane, area, nearest, tile)
                              : halve(cutter, area, nearest, tile);
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
  const Nearest nearest = keep_eyes(cutter, ball, piece.eyes);
  if (piece.eyes.empty()) return;
  if (piece.path == 0) return part_group(cutter, piece, ball, rest);
  const double size = cutter.is_even ? kEvenTileSize : kTileSize;
  if (ball.radius_m <= size * least(nearest) || std::countl_zero(piece.path) <= 2) {
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

// Adds the eyes of a sonar, merging equal ones in a row, and returns the index of each ping's eye.
std::vector<std::uint32_t> add_eyes(std::span<const Pose> by_ping, std::uint32_t view,
                                    std::vector<Eye>& eyes) {
  std::vector<std::uint32_t> of_ping;
  const std::size_t first = eyes.size();
  for (const Pose& pose : by_ping) {
    if (eyes.size() == first || !(eyes.back().pose == pose)) eyes.push_back({pose, view});
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

double longest_range_m(const std::vector<SurfaceViews>& views) {
  double range_m = 0;
  for (const SurfaceViews& view : views) range_m = std::max(range_m, view.sonar.range_max_m);
  return range_m;
}

bool know_spacings(const std::vector<SurfaceViews>& views) {
  return std::ranges::none_of(views,
                              [](const SurfaceViews& view) { return view.even.spacing_m.empty(); });
}

std::uint64_t most_of(const std::vector<std::uint64_t>& parts) {
  std::uint64_t most = 0;
  for (const std::uint64_t count : parts) {
    most = std::max(
        most, static_cast<std::uint64_t>(std::ceil(static_cast<double>(count) / kCountedParts)));
  }
  return most;
}

}  // namespace

SurfaceTiles surface_tiles(const World& world, const std::vector<SurfaceViews>& views,
                           const Workers& workers) {
  ENSONIFY_ASSERT(views.size() <= kMostViews);
  SurfaceTiles result;
  std::vector<std::vector<std::uint64_t>> leaves(views.size());  // by sonar and ping
  std::map<std::string, std::uint64_t> seen;
  const double range_max_m = longest_range_m(views);
  for (std::uint32_t i = 0; i < world.objects.size(); ++i) {
    Cutter cutter{views, i, key_of(world, world.objects[i], seen), {}, {}, {}, {}, {}};
    cutter.is_even = know_spacings(views) && is_even(world.objects[i]);
    std::vector<std::vector<std::uint32_t>> eye_of_ping;
    for (std::uint32_t view = 0; view < views.size(); ++view) {
      eye_of_ping.push_back(add_eyes(views[view].sonar_in_object(i), view, cutter.eyes));
    }
    cutter.leaves = std::make_unique<std::atomic<std::uint64_t>[]>(cutter.eyes.size());
    cutter.primitives = primitives_of(world.objects[i].shape, range_max_m, cutter.eyes);
    cut_object(cutter, workers, result.tiles);
    result.instance.push_back(world.objects[i].instance);
    for (std::size_t view = 0; view < views.size(); ++view) {
      leaves[view].resize(eye_of_ping[view].size());
      for (std::size_t ping = 0; ping < leaves[view].size(); ++ping) {
        leaves[view][ping] += cutter.leaves[eye_of_ping[view][ping]];
      }
    }
  }
  for (const auto& parts : leaves) result.most_leaves.push_back(most_of(parts));
  return result;
}

}  // namespace ensonify
