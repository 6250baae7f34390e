#include "world/convex.h"

#include <libqhull_r/libqhull_r.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

namespace ensonify {
namespace {

double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

Triangle oriented(Triangle t, Vec3 outwards) {
  if (dot(cross(t[1] - t[0], t[2] - t[0]), outwards) < 0) std::swap(t[1], t[2]);
  return t;
}

// Empty if Qhull finds no body. Qhull's output is discarded.
std::vector<Triangle> hull_triangles(std::vector<Vec3> points) {
  static_assert(sizeof(Vec3) == 3 * sizeof(coordT));
  const std::unique_ptr<FILE, int (*)(FILE*)> nowhere(std::fopen("/dev/null", "w"), std::fclose);
  if (points.size() < 4 || !nowhere) return {};
  auto state = std::make_unique<qhT>();
  qh_zero(state.get(), nowhere.get());
  char options[] = "qhull Qt Pp";
  const int failed =
      qh_new_qhull(state.get(), 3, static_cast<int>(points.size()), &points[0].x, False, options,
                   nowhere.get(), nowhere.get());
  std::vector<Triangle> triangles;
  for (facetT* facet = state->facet_list; failed == 0 && facet != nullptr && facet->next != nullptr;
       facet = facet->next) {
    Triangle corners;
    for (int i = 0; i < 3; ++i) {
      const auto* vertex = static_cast<const vertexT*>(facet->vertices->e[i].p);
      corners[i] = {vertex->point[0], vertex->point[1], vertex->point[2]};
    }
    triangles.push_back(
        oriented(corners, {facet->normal[0], facet->normal[1], facet->normal[2]}));
  }
  qh_freeqhull(state.get(), !qh_ALL);
  int left = 0, total = 0;
  qh_memfreeshort(state.get(), &left, &total);
  return triangles;
}

Vec3 centre_of_mass(const std::vector<Triangle>& hull) {
  Vec3 sum;
  double volume = 0;
  for (const Triangle& t : hull) {
    const double of = dot(t[0], cross(t[1], t[2])) / 6;
    sum = sum + (of / 4) * (t[0] + t[1] + t[2]);
    volume += of;
  }
  return (1 / volume) * sum;
}

bool lies_over(const Triangle& t, Vec3 normal, Vec3 point) {
  for (int i = 0; i < 3; ++i) {
    const Vec3 a = t[i], b = t[(i + 1) % 3];
    if (dot(cross(b - a, point - a), normal) < 0) return false;
  }
  return true;
}

struct Face {
  Vec3 normal;
  double solid_angle = 0;
  bool is_stable = false;
};

}  // namespace

double solid_angle_sr(const Triangle& triangle, Vec3 from) {
  const Vec3 p = triangle[0] - from, q = triangle[1] - from, r = triangle[2] - from;
  const double a = length(p), b = length(q), c = length(r);
  return 2 * std::atan2(dot(p, cross(q, r)),
                        a * b * c + dot(p, q) * c + dot(q, r) * a + dot(r, p) * b);
}

std::vector<Point2> convex_hull(std::vector<Point2> points) {
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Point2> hull;
  const auto add = [&](const Point2& point, std::size_t kept) {
    while (hull.size() >= kept + 2 && turn(hull[hull.size() - 2], hull.back(), point) <= 0) {
      hull.pop_back();
    }
    hull.push_back(point);
  };
  for (const Point2& point : points) add(point, 0);
  hull.pop_back();
  const std::size_t lower = hull.size();
  for (auto point = points.rbegin(); point != points.rend(); ++point) add(*point, lower);
  hull.pop_back();
  return hull;
}

Result<std::vector<RestFace>> rest_faces(const std::vector<Vec3>& points) {
  constexpr double kSameNormal = 1 - 1e-9;  // cosine
  const std::vector<Triangle> hull = hull_triangles(points);
  if (hull.empty()) return Error{ErrorKind::usage, "its points lie in one plane"};
  const Vec3 centre = centre_of_mass(hull);
  std::vector<Face> faces;
  for (const Triangle& triangle : hull) {
    const Vec3 across = cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
    if (!(length(across) > 0)) continue;
    const Vec3 normal = normalized(across);
    auto face = std::find_if(faces.begin(), faces.end(), [&](const Face& known) {
      return dot(known.normal, normal) > kSameNormal;
    });
    if (face == faces.end()) face = faces.insert(faces.end(), Face{normal});
    face->solid_angle += solid_angle_sr(triangle, centre);
    face->is_stable = face->is_stable || lies_over(triangle, normal, centre);
  }
  double sum = 0;
  for (const Face& face : faces) sum += face.is_stable ? face.solid_angle : 0;
  std::vector<RestFace> rest;
  for (const Face& face : faces) {
    if (face.is_stable) rest.push_back({face.normal, face.solid_angle / sum});
  }
  std::stable_sort(rest.begin(), rest.end(),
                   [](const RestFace& a, const RestFace& b) { return a.share > b.share; });
  return rest;
}

}  // namespace ensonify
