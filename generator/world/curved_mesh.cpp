#include "world/curved_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "world/body_normals.h"

namespace ensonify {
namespace {

using Shares = std::array<double, 3>;  // barycentric coordinates

// A triangle with the normals of its body at the corners.
struct CurvedPatch {
  std::array<Vec3, 3> place, normal;
};

CurvedPatch patch_of(const Mesh& mesh, const BodyNormals& body, std::size_t triangle) {
  CurvedPatch patch;
  for (int c = 0; c < 3; ++c) patch.place[c] = corner_place(mesh, triangle, c);
  patch.normal = body.corner[triangle];
  return patch;
}

Vec3 mean_of(const std::array<Vec3, 3>& values, const Shares& share) {
  return share[0] * values[0] + share[1] * values[1] + share[2] * values[2];
}

struct Offset {
  double size_m = 0;
  Vec3 normal;
};

// From the flat triangle to the body.
Offset offset_at(const CurvedPatch& patch, const Shares& share) {
  double bend_m = 0;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    bend_m += share[i] * share[j] *
              dot(patch.normal[j] - patch.normal[i], patch.place[j] - patch.place[i]);
  }
  const Vec3 normal = mean_of(patch.normal, share);
  const double size = length(normal);
  return {bend_m / (1 + size), unit_or_zero(normal)};
}

// The shares on the side opposite to corner k, `along` of the way from corner k + 1 to k + 2.
Shares on_side(int k, double along) {
  Shares share{};
  share[(k + 1) % 3] = 1 - along;
  share[(k + 2) % 3] = along;
  return share;
}

double side_sag_m(const CurvedPatch& patch, int k) {
  return std::abs(offset_at(patch, on_side(k, 0.5)).size_m);
}

// The offset that both bodies at an edge ask for: the smallest one with the size of each along its
// own normal.
Vec3 shared_offset(const Offset& a, const Offset& b) {
  const double c = dot(a.normal, b.normal), rest = 1 - c * c;
  // Normals that differ by less than 10 degrees do not tell where the edge is.
  if (rest < 0.03) return 0.5 * (a.size_m * a.normal + b.size_m * b.normal);
  return ((a.size_m - c * b.size_m) / rest) * a.normal +
         ((b.size_m - c * a.size_m) / rest) * b.normal;
}

// Cuts one mesh.
struct Cutter {
  const Mesh& mesh;
  const BodyNormals& body;
  double wavelength_m = 0;
  Mesh result;
  std::vector<std::uint32_t> kept;  // by vertex of `mesh`: its number in the result

  int side_parts(std::size_t triangle, int k) const;
  Vec3 side_point(std::size_t triangle, int k, int step, int steps) const;
  Vec3 inner_point(const CurvedPatch& patch, std::size_t triangle, const Shares& share) const;
  void keep(std::size_t triangle);
  void cut(std::size_t triangle, int steps);

 private:
  int side_of_neighbor(std::size_t triangle, int k) const;
  Vec3 curve(std::size_t triangle, int k, double along) const;
  void add_vertex(std::size_t triangle, const Shares& share, Vec3 place, Vec3 normal);
};

// The neighbor's side that is side k of the triangle.
int Cutter::side_of_neighbor(std::size_t triangle, int k) const {
  const auto& back = body.neighbor[body.neighbor[triangle][k]];
  return static_cast<int>(std::ranges::find(back, triangle) - back.begin());
}

// Into how many parts the side is divided, equally for both triangles.
int Cutter::side_parts(std::size_t triangle, int k) const {
  double sag_m = side_sag_m(patch_of(mesh, body, triangle), k);
  if (const std::uint32_t other = body.neighbor[triangle][k]; other != BodyNormals::kNone) {
    sag_m = std::max(sag_m, side_sag_m(patch_of(mesh, body, other), side_of_neighbor(triangle, k)));
  }
  return std::max(
      1, static_cast<int>(std::ceil(std::sqrt(sag_m / (kSag_wavelengths * wavelength_m)) - 1e-9)));
}

// A point of the body on side k, the same for both triangles: it is found from the lower triangle.
Vec3 Cutter::curve(std::size_t triangle, int k, double along) const {
  const std::uint32_t other = body.neighbor[triangle][k];
  if (other != BodyNormals::kNone && other < triangle) {
    return curve(other, side_of_neighbor(triangle, k), 1 - along);
  }
  const CurvedPatch patch = patch_of(mesh, body, triangle);
  const Shares share = on_side(k, along);
  const Offset own = offset_at(patch, share);
  const Vec3 flat = mean_of(patch.place, share);
  if (other == BodyNormals::kNone) return flat + own.size_m * own.normal;
  const Offset beyond =
      offset_at(patch_of(mesh, body, other), on_side(side_of_neighbor(triangle, k), 1 - along));
  if (length(own.normal - beyond.normal) < 1e-9) return flat + own.size_m * own.normal;
  return flat + shared_offset(own, beyond);
}

// Point `step` of `steps` on side k, on the chords between the points of side_parts().
Vec3 Cutter::side_point(std::size_t triangle, int k, int step, int steps) const {
  const int parts = side_parts(triangle, k);
  const int part = std::min(step * parts / steps, parts - 1);
  const double within = static_cast<double>(step) * parts / steps - part;
  const Vec3 from = curve(triangle, k, static_cast<double>(part) / parts);
  if (within == 0) return from;
  return (1 - within) * from + within * curve(triangle, k, static_cast<double>(part + 1) / parts);
}

// Moves with the sides, where these do not lie on the triangle's own body.
Vec3 Cutter::inner_point(const CurvedPatch& patch, std::size_t triangle,
                         const Shares& share) const {
  const Offset own = offset_at(patch, share);
  Vec3 point = mean_of(patch.place, share) + own.size_m * own.normal;
  for (int k = 0; k < 3; ++k) {
    if (body.neighbor[triangle][k] == BodyNormals::kNone) continue;
    const double along = share[(k + 2) % 3] / (1 - share[k]);
    const Shares beside = on_side(k, along);
    const Offset there = offset_at(patch, beside);
    const Vec3 moved =
        curve(triangle, k, along) - mean_of(patch.place, beside) - there.size_m * there.normal;
    point = point + (1 - share[k]) * (1 - share[k]) * moved;
  }
  return point;
}

void Cutter::add_vertex(std::size_t triangle, const Shares& share, Vec3 place, Vec3 normal) {
  const auto& corner = mesh.triangles[triangle];
  result.vertices.push_back(to_floats(place));
  result.normals.push_back(to_floats(normal));
  const auto mixed = [&](const auto& value) {
    return static_cast<float>(share[0] * value(corner[0]) + share[1] * value(corner[1]) +
                              share[2] * value(corner[2]));
  };
  if (!mesh.reflectivity.empty()) {
    result.reflectivity.push_back(mixed([&](std::uint32_t v) { return mesh.reflectivity[v]; }));
  }
  if (!mesh.colors.empty()) {
    const auto channel = [&](int c) {
      return mixed([&](std::uint32_t v) { return mesh.colors[v][c]; });
    };
    result.colors.push_back({channel(0), channel(1), channel(2)});
  }
  if (!mesh.uv.empty()) {
    result.uv.push_back({mixed([&](std::uint32_t v) { return mesh.uv[v][0]; }),
                         mixed([&](std::uint32_t v) { return mesh.uv[v][1]; })});
  }
}

void Cutter::keep(std::size_t triangle) {
  std::array<std::uint32_t, 3> corners{};
  for (int c = 0; c < 3; ++c) {
    const std::uint32_t v = mesh.triangles[triangle][c];
    if (kept[v] == BodyNormals::kNone) {
      kept[v] = static_cast<std::uint32_t>(result.vertices.size());
      Shares share{};
      share[c] = 1;
      add_vertex(triangle, share, corner_place(mesh, triangle, c),
                 mesh.normals.empty() ? body.corner[triangle][c] : to_vec3(mesh.normals[v]));
    }
    corners[c] = kept[v];
  }
  result.triangles.push_back(corners);
}

void Cutter::cut(std::size_t triangle, int steps) {
  const CurvedPatch patch = patch_of(mesh, body, triangle);
  const auto first = static_cast<std::uint32_t>(result.vertices.size());
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps - i; ++j) {
      const int l = steps - i - j;
      const Shares share{static_cast<double>(l) / steps, static_cast<double>(i) / steps,
                         static_cast<double>(j) / steps};
      Vec3 place;
      if (std::max({i, j, l}) == steps) {
        place = mean_of(patch.place, share);
      } else if (l == 0) {
        place = side_point(triangle, 0, j, steps);
      } else if (i == 0) {
        place = side_point(triangle, 1, l, steps);
      } else if (j == 0) {
        place = side_point(triangle, 2, i, steps);
      } else {
        place = inner_point(patch, triangle, share);
      }
      add_vertex(triangle, share, place, unit_or_zero(mean_of(patch.normal, share)));
    }
  }
  // Row i begins behind i rows of steps + 1, steps, ... vertices.
  const auto at = [&](int i, int j) {
    return first + static_cast<std::uint32_t>(i * (steps + 1) - i * (i - 1) / 2 + j);
  };
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; j < steps - i; ++j) {
      result.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + j + 1 < steps) {
        result.triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    }
  }
}

}  // namespace

FacetSag facet_sag(const Mesh& read) {
  const Mesh mesh = turned_alike(read);
  const BodyNormals body = body_normals(mesh);
  FacetSag worst;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const CurvedPatch patch = patch_of(mesh, body, t);
    for (int k = 0; k < 3; ++k) {
      const double sag_m = side_sag_m(patch, k);
      if (sag_m <= worst.sag_m) continue;
      const double side_m = length(patch.place[(k + 1) % 3] - patch.place[(k + 2) % 3]);
      worst = {sag_m, side_m, side_m * side_m / (8 * sag_m)};
    }
  }
  return worst;
}

Result<Mesh> curved_mesh(const Mesh& read, double wavelength_m) {
  const Mesh mesh = turned_alike(read);
  const BodyNormals body = body_normals(mesh);
  Cutter cutter{mesh,
                body,
                wavelength_m,
                {},
                std::vector<std::uint32_t>(mesh.vertices.size(), BodyNormals::kNone)};
  std::vector<int> steps(mesh.triangles.size());
  double total = 0;
  for (std::size_t t = 0; t < steps.size(); ++t) {
    for (int k = 0; k < 3; ++k) steps[t] = std::max(steps[t], cutter.side_parts(t, k));
    total += static_cast<double>(steps[t]) * steps[t];
  }
  if (total > kMostCurvedTriangles) {
    return Error{
        ErrorKind::usage,
        fmt::format("a smooth body at a wavelength of {:.3g} mm would need {:.3g} million "
                    "triangles in place of its {}, and at most {} million are made; expected "
                    "a lower frequency, a smaller body or normals: face",
                    1e3 * wavelength_m, 1e-6 * total, mesh.triangles.size(),
                    kMostCurvedTriangles / 1'000'000)};
  }
  for (std::size_t t = 0; t < steps.size(); ++t) {
    if (steps[t] == 1) {
      cutter.keep(t);
    } else {
      cutter.cut(t, steps[t]);
    }
    if (!mesh.part.empty()) cutter.result.part.resize(cutter.result.triangles.size(), mesh.part[t]);
  }
  cutter.result.part_names = mesh.part_names;
  cutter.result.warnings = mesh.warnings;
  return std::move(cutter.result);
}

}  // namespace ensonify
