#include "world/everyday_objects/everyday_objects.h"

#include <cmath>
#include <utility>

#include "core/units.h"

namespace ensonify {
namespace {

void add_lid(const Ring& ring, std::uint32_t first, bool end, Solid& solid) {
  const auto centre = static_cast<std::uint32_t>(solid.vertices.size());
  const auto count = static_cast<std::uint32_t>(ring.size());
  Vec3 sum;
  for (const Vec3& p : ring) sum = sum + p;
  solid.vertices.push_back((1.0 / count) * sum);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t a = first + i, b = first + (i + 1) % count;
    solid.triangles.push_back(end ? std::array{centre, a, b} : std::array{centre, b, a});
  }
}

Vec3 tangent(const std::vector<TubePoint>& curve, std::size_t i, Ends ends) {
  const std::size_t n = curve.size();
  const bool looped = ends == Ends::looped;
  const std::size_t before = i > 0 ? i - 1 : (looped ? n - 1 : 0);
  const std::size_t after = i + 1 < n ? i + 1 : (looped ? 0 : n - 1);
  return normalized(curve[after].position - curve[before].position);
}

double corner_angle(int corner, int corners) { return 2 * kPi * corner / corners; }

}  // namespace

double volume(const Solid& solid) {
  double six = 0;
  for (const auto& [a, b, c] : solid.triangles) {
    six += dot(solid.vertices[a], cross(solid.vertices[b], solid.vertices[c]));
  }
  return six / 6;
}

Solid loft(const std::vector<Ring>& rings, Ends ends) {
  Solid solid;
  const auto count = static_cast<std::uint32_t>(rings.front().size());
  for (const Ring& ring : rings) {
    solid.vertices.insert(solid.vertices.end(), ring.begin(), ring.end());
  }
  const auto n = static_cast<std::uint32_t>(rings.size());
  for (std::uint32_t r = 0; r + 1 < n || (r < n && ends == Ends::looped); ++r) {
    const std::uint32_t here = r * count, there = (r + 1) % n * count;
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t j = (i + 1) % count;
      solid.triangles.push_back({here + i, here + j, there + j});
      solid.triangles.push_back({here + i, there + j, there + i});
    }
  }
  if (ends == Ends::capped) {
    add_lid(rings.front(), 0, false, solid);
    add_lid(rings.back(), (n - 1) * count, true, solid);
  }
  if (volume(solid) < 0) {
    for (auto& triangle : solid.triangles) std::swap(triangle[1], triangle[2]);
  }
  return solid;
}

Solid turned(const std::vector<ProfilePoint>& profile, int corners, Ends ends) {
  std::vector<Ring> rings;
  for (const ProfilePoint& p : profile) {
    Ring& ring = rings.emplace_back();
    for (int c = 0; c < corners; ++c) {
      const double angle = corner_angle(c, corners);
      ring.push_back({p.radius * std::cos(angle), p.radius * std::sin(angle), p.z});
    }
  }
  return loft(rings, ends);
}

Solid tube(const std::vector<TubePoint>& curve, Vec3 plane_normal, int corners, Ends ends) {
  std::vector<Ring> rings;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Vec3 side = cross(tangent(curve, i, ends), plane_normal);
    Ring& ring = rings.emplace_back();
    for (int c = 0; c < corners; ++c) {
      const double angle = corner_angle(c, corners);
      ring.push_back(curve[i].position +
                     curve[i].radius * (std::cos(angle) * side + std::sin(angle) * plane_normal));
    }
  }
  return loft(rings, ends);
}

Solid tube(const std::vector<Vec3>& curve, double radius, int corners, Ends ends) {
  std::vector<TubePoint> points;
  for (const Vec3& p : curve) points.push_back({p, radius});
  return tube(points, {0, 0, 1}, corners, ends);
}

Solid torus(Vec3 centre, double radius, double bar_radius, int steps) {
  std::vector<Vec3> circle = arc(centre, radius, 0, 2 * kPi, steps);
  circle.pop_back();
  return tube(circle, bar_radius, 12, Ends::looped);
}

Solid box(Vec3 size) {
  const double x = size.x / 2, y = size.y / 2, z = size.z / 2;
  return loft({{{-x, -y, -z}, {x, -y, -z}, {x, y, -z}, {-x, y, -z}},
               {{-x, -y, z}, {x, -y, z}, {x, y, z}, {-x, y, z}}},
              Ends::capped);
}

Solid joined(const std::vector<Solid>& parts) {
  Solid whole;
  for (const Solid& part : parts) {
    const auto first = static_cast<std::uint32_t>(whole.vertices.size());
    whole.vertices.insert(whole.vertices.end(), part.vertices.begin(), part.vertices.end());
    for (const auto& [a, b, c] : part.triangles) {
      whole.triangles.push_back({first + a, first + b, first + c});
    }
  }
  return whole;
}

Solid moved(Solid solid, const Pose& pose) {
  for (Vec3& p : solid.vertices) p = transform_point(pose, p);
  return solid;
}

std::vector<Vec3> arc(Vec3 centre, double radius, double from_rad, double to_rad, int steps) {
  std::vector<Vec3> points;
  for (int i = 0; i <= steps; ++i) {
    const double angle = from_rad + (to_rad - from_rad) * i / steps;
    points.push_back(centre + radius * Vec3{std::cos(angle), std::sin(angle), 0});
  }
  return points;
}

std::vector<Vec3> bezier(const std::array<Vec3, 4>& control, int steps) {
  std::vector<Vec3> points;
  for (int i = 0; i <= steps; ++i) {
    const double u = static_cast<double>(i) / steps, v = 1 - u;
    points.push_back(v * v * v * control[0] + 3 * v * v * u * control[1] +
                     3 * v * u * u * control[2] + u * u * u * control[3]);
  }
  return points;
}

}  // namespace ensonify
