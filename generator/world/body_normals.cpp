#include "world/body_normals.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/units.h"

namespace ensonify {
namespace {

// Own normals that agree to this say the same; single precision and transforms change less.
constexpr double kEqualNormals = 1e-3;

Vec3 face_normal(const Mesh& mesh, std::size_t triangle) {
  const Vec3 a = corner_place(mesh, triangle, 0);
  return unit_or_zero(
      cross(corner_place(mesh, triangle, 1) - a, corner_place(mesh, triangle, 2) - a));
}

// Equal numbers for vertices at equal places.
std::vector<std::uint32_t> welded(const Mesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size()), id(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, [&](std::uint32_t v) { return mesh.vertices[v]; });
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i > 0 && mesh.vertices[order[i]] != mesh.vertices[order[i - 1]]) ++next;
    id[order[i]] = next;
  }
  return id;
}

struct Side {
  std::uint32_t low = 0, high = 0;  // welded vertices
  std::uint32_t triangle = 0;
  std::uint8_t opposite = 0;  // the corner that is not on the side
  bool rising = false;        // from low to high in the order of the triangle's corners
};

std::vector<Side> sorted_sides(const Mesh& mesh, const std::vector<std::uint32_t>& place) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t from = place[mesh.triangles[t][(k + 1) % 3]];
      const std::uint32_t to = place[mesh.triangles[t][(k + 2) % 3]];
      sides.push_back({std::min(from, to), std::max(from, to), t, k, from < to});
    }
  }
  std::ranges::sort(sides, {}, [](const Side& side) {
    return std::tuple(side.low, side.high, side.triangle, side.opposite);
  });
  return sides;
}

// Two sides that are one.
struct Seam {
  Side a, b;
};

std::vector<Seam> seams_of(const std::vector<Side>& sides) {
  std::vector<Seam> seams;
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].low == sides[i].low &&
           sides[end].high == sides[i].high) {
      ++end;
    }
    if (end - i == 2) seams.push_back({sides[i], sides[i + 1]});
    i = end;
  }
  return seams;
}

// The corner of the side's triangle at its low or high end.
int corner_at(const Side& side, bool low) {
  return (side.opposite + (side.rising == low ? 1 : 2)) % 3;
}

// The normals that the mesh has of its own, by vertex; none where they only repeat the faces.
std::vector<Vec3> own_normals(const Mesh& mesh, const std::vector<Vec3>& face,
                              const std::vector<std::uint32_t>& place) {
  if (mesh.normals.size() != mesh.vertices.size()) return {};
  std::vector<Vec3> mean(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) mean[place[v]] = mean[place[v]] + face[t];
  }
  std::vector<Vec3> own(mesh.vertices.size());
  bool say_more = false;
  for (std::size_t v = 0; v < own.size(); ++v) {
    own[v] = unit_or_zero(to_vec3(mesh.normals[v]));
    say_more |= length(own[v] - unit_or_zero(mean[place[v]])) > kEqualNormals;
  }
  if (!say_more) own.clear();
  return own;
}

// Sets of corners that share a normal.
class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    const std::size_t first = root(a), second = root(b);
    parent_[std::max(first, second)] = std::min(first, second);
  }

 private:
  std::vector<std::size_t> parent_;
};

std::size_t corner_number(const Side& side, bool low) {
  return 3 * std::size_t{side.triangle} + corner_at(side, low);
}

// Max's weight times the face's normal: the cross product of the two sides at a corner over the
// squares of their lengths.
Vec3 weighted_normal(const Mesh& mesh, std::size_t triangle, int corner) {
  const Vec3 p = corner_place(mesh, triangle, corner);
  const Vec3 a = corner_place(mesh, triangle, (corner + 1) % 3) - p;
  const Vec3 b = corner_place(mesh, triangle, (corner + 2) % 3) - p;
  const double squares = dot(a, a) * dot(b, b);
  return squares > 0 ? (1 / squares) * cross(a, b) : Vec3{};
}

// Whether the own normals at a corner can be those of a body near this face.
bool fits(Vec3 own, Vec3 face) { return dot(own, face) > std::cos(radians(kLargestBend_deg)); }

// The height of the triangle over the side.
double height_m(const Mesh& mesh, const Side& side) {
  const Vec3 from = corner_place(mesh, side.triangle, corner_at(side, true));
  const Vec3 along = corner_place(mesh, side.triangle, corner_at(side, false)) - from;
  const Vec3 to_top = corner_place(mesh, side.triangle, side.opposite) - from;
  return length(cross(along, to_top)) / length(along);
}

// Whether the body can bend alike on both sides of a seam. Where a narrow face meets a wide one, as
// a chamfer meets a lid or a round end meets a long mantle, the wide one is straight.
bool bends_alike(const Mesh& mesh, const Seam& seam) {
  const double a_m = height_m(mesh, seam.a), b_m = height_m(mesh, seam.b);
  return std::max(a_m, b_m) <= kLargestStep * std::min(a_m, b_m);
}

// Triangles behind the sides of each triangle, and whether they turn the other way around.
struct Neighbors {
  std::array<std::uint32_t, 3> triangle{BodyNormals::kNone, BodyNormals::kNone, BodyNormals::kNone};
  std::array<bool, 3> turned{};
};

std::vector<Neighbors> neighbors_of(std::size_t triangles, const std::vector<Seam>& seams) {
  std::vector<Neighbors> found(triangles);
  for (const auto& [a, b] : seams) {
    const bool turned = a.rising == b.rising;
    found[a.triangle].triangle[a.opposite] = b.triangle;
    found[b.triangle].triangle[b.opposite] = a.triangle;
    found[a.triangle].turned[a.opposite] = found[b.triangle].turned[b.opposite] = turned;
  }
  return found;
}

}  // namespace

Mesh turned_alike(const Mesh& mesh) {
  Mesh result = mesh;
  const std::vector<Seam> seams = seams_of(sorted_sides(mesh, welded(mesh)));
  if (std::ranges::none_of(seams, [](const Seam& s) { return s.a.rising == s.b.rising; })) {
    return result;
  }
  const std::vector<Neighbors> neighbors = neighbors_of(mesh.triangles.size(), seams);
  // Unknown, as the first triangle of its part of the surface, or the other way around.
  enum class Turn : std::uint8_t { unknown, kept, turned };
  std::vector<Turn> turn(mesh.triangles.size(), Turn::unknown);
  std::vector<std::uint32_t> open;
  for (std::uint32_t first = 0; first < turn.size(); ++first) {
    if (turn[first] != Turn::unknown) continue;
    turn[first] = Turn::kept;
    open.push_back(first);
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      if (turn[t] == Turn::turned) std::swap(result.triangles[t][1], result.triangles[t][2]);
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t next = neighbors[t].triangle[k];
        if (next == BodyNormals::kNone || turn[next] != Turn::unknown) continue;
        const bool alike = neighbors[t].turned[k] == (turn[t] == Turn::turned);
        turn[next] = alike ? Turn::kept : Turn::turned;
        open.push_back(next);
      }
    }
  }
  return result;
}

BodyNormals body_normals(const Mesh& mesh) {
  const std::size_t count = mesh.triangles.size();
  std::vector<Vec3> face(count);
  for (std::size_t t = 0; t < count; ++t) face[t] = face_normal(mesh, t);
  const std::vector<std::uint32_t> place = welded(mesh);
  const std::vector<Seam> seams = seams_of(sorted_sides(mesh, place));
  const std::vector<Vec3> own = own_normals(mesh, face, place);
  const auto own_at = [&](std::size_t corner) {
    return own[mesh.triangles[corner / 3][corner % 3]];
  };
  const auto has_own = [&](std::size_t corner) {
    return !own.empty() && fits(own_at(corner), face[corner / 3]);
  };

  BodyNormals body;
  body.neighbor.assign(count, {BodyNormals::kNone, BodyNormals::kNone, BodyNormals::kNone});
  Groups groups(3 * count);
  for (const Seam& seam : seams) {
    const auto& [a, b] = seam;
    // A surface with one side has seams where its triangles turn differently, and two triangles
    // with more than one common side are the two faces of a leaf.
    if (a.rising == b.rising) continue;
    if (std::ranges::count(body.neighbor[a.triangle], b.triangle) > 0) continue;
    body.neighbor[a.triangle][a.opposite] = b.triangle;
    body.neighbor[b.triangle][b.opposite] = a.triangle;
    bool told = true, same = true;
    for (const bool low : {true, false}) {
      const std::size_t i = corner_number(a, low), k = corner_number(b, low);
      told = told && has_own(i) && has_own(k);
      same = same && told && length(own_at(i) - own_at(k)) <= kEqualNormals;
    }
    const Vec3 one = face[a.triangle], other = face[b.triangle];
    const bool flat = length(one - other) <= kEqualNormals;
    const bool smooth = told ? same : flat || (fits(one, other) && bends_alike(mesh, seam));
    if (!smooth) continue;
    for (const bool low : {true, false}) groups.join(corner_number(a, low), corner_number(b, low));
  }
  std::vector<Vec3> told_sum(3 * count), weighted_sum(3 * count);
  std::vector<bool> untold(3 * count);
  for (std::size_t corner = 0; corner < 3 * count; ++corner) {
    const std::size_t root = groups.root(corner);
    weighted_sum[root] =
        weighted_sum[root] + weighted_normal(mesh, corner / 3, static_cast<int>(corner % 3));
    if (has_own(corner)) {
      told_sum[root] = told_sum[root] + own_at(corner);
    } else {
      untold[root] = true;
    }
  }
  body.corner.resize(count);
  for (std::size_t corner = 0; corner < 3 * count; ++corner) {
    const std::size_t root = groups.root(corner);
    const Vec3 normal = unit_or_zero(untold[root] ? weighted_sum[root] : told_sum[root]);
    body.corner[corner / 3][corner % 3] = dot(normal, normal) > 0 ? normal : face[corner / 3];
  }
  return body;
}

}  // namespace ensonify
