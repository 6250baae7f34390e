#include "world/import/polygon.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/vec.h"
#include "world/mesh.h"

namespace ensonify {
namespace {

using Corners = std::vector<std::array<float, 3>>;
using Index = std::uint32_t;

// A corner as seen along the normal of the face.
struct Point {
  double x = 0, y = 0;
  friend bool operator==(const Point&, const Point&) = default;
};

// Twice the area of the triangle, positive if it is counterclockwise. Coordinates are floats, so
// that their differences and both products are exact, and zero and the sign are, too, unless some
// coordinates of the face are a million times smaller than others. Then a wrong sign is one of a
// length that does not count.
double turn(Point a, Point b, Point c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

double distance(Point a, Point b) { return std::hypot(b.x - a.x, b.y - a.y); }

// The distance of p from the line through a and b, positive on its left; 0 if a is b.
double left_of(Point a, Point b, Point p) {
  const double edge = distance(a, b);
  return edge > 0 ? turn(a, b, p) / edge : 0;
}

// Cuts triangles off the corners of a counterclockwise polygon until none is left.
class Clipping {
 public:
  Clipping(const std::vector<Point>& points, double rounding)
      : points_(points),
        rounding_(rounding),
        left_(points.size()),
        next_(points.size()),
        before_(points.size()),
        convex_(points.size()) {
    const auto count = static_cast<Index>(points.size());
    for (Index i = 0; i < count; ++i) {
      next_[i] = (i + 1) % count;
      before_[i] = (i + count - 1) % count;
    }
    for (Index i = 0; i < count; ++i) {
      convex_[i] = turn_at(i) > 0;
      if (!convex_[i]) others_.push_back(i);
    }
    std::sort(others_.begin(), others_.end(),
              [&](Index a, Index b) { return points[a].x < points[b].x; });
  }

  DividedFace run() {
    Index corner = 0;
    for (std::size_t i = 0; i < points_.size() && left_ >= 3; ++i) {
      corner = is_spike(corner) ? remove(corner) : next_[corner];
    }
    for (std::size_t tried = 0; left_ >= 3;) {
      if (convex_[corner] && !is_blocked(corner)) {
        corner = next_[cut(corner)];  // leaves one out: fewer slivers
      } else if (++tried < left_) {
        corner = next_[corner];
        continue;
      } else {
        face_.simple = false;
        while (left_ >= 3) corner = cut(corner);
      }
      tried = 0;
    }
    return std::move(face_);
  }

 private:
  double turn_at(Index i) const { return turn(points_[before_[i]], points_[i], points_[next_[i]]); }

  // Whether the outline turns back at this corner, or does not move.
  bool is_spike(Index i) const {
    const Point a = points_[before_[i]], b = points_[i], c = points_[next_[i]];
    if (a == b || b == c) return true;
    return (a.x - b.x) * (c.x - b.x) + (a.y - b.y) * (c.y - b.y) > 0 && height(i) <= rounding_;
  }

  // Of the triangle at this corner, over its longest edge.
  double height(Index i) const {
    const Point a = points_[before_[i]], b = points_[i], c = points_[next_[i]];
    const double longest = std::max({distance(a, b), distance(b, c), distance(c, a)});
    return longest > 0 ? std::abs(turn(a, b, c)) / longest : 0;
  }

  // Cuts off the triangle at this corner. Returns a corner behind it.
  Index cut(Index i) {
    face_.triangles.push_back({before_[i], i, next_[i]});
    return remove(i);
  }

  // Removes a corner, and spikes that appear: they would pass for corners of what is outside.
  Index remove(Index i) {
    for (;;) {
      const Index a = before_[i], c = next_[i];
      next_[a] = c;
      before_[c] = a;
      next_[i] = i;
      --left_;
      convex_[a] = turn_at(a) > 0;
      convex_[c] = turn_at(c) > 0;
      if (left_ < 3) return c;
      if (is_spike(c)) {
        i = c;
      } else if (is_spike(a)) {
        i = a;
      } else {
        return c;
      }
    }
  }

  bool is_cut(Index i) const { return next_[i] == i; }

  // Whether the polygon reaches into the triangle that is cut off at this convex corner. Corners
  // that turn left alone cannot: the part nearest to the corner turns right or not at all.
  bool is_blocked(Index i) const {
    const Point a = points_[before_[i]], b = points_[i], c = points_[next_[i]];
    const double low_x = std::min({a.x, b.x, c.x}) - rounding_;
    const double high_x = std::max({a.x, b.x, c.x}) + rounding_;
    const double low_y = std::min({a.y, b.y, c.y}) - rounding_;
    const double high_y = std::max({a.y, b.y, c.y}) + rounding_;
    auto at = std::lower_bound(others_.begin(), others_.end(), low_x,
                               [&](Index other, double x) { return points_[other].x < x; });
    for (; at != others_.end() && points_[*at].x <= high_x; ++at) {
      const Index p = *at;
      if (points_[p].y < low_y || points_[p].y > high_y) continue;
      if (convex_[p] || is_cut(p) || p == before_[i] || p == next_[i]) continue;
      if (is_in(a, b, c, p)) return true;
    }
    return false;
  }

  // Whether corner p is in the triangle or on its edge from a to c, or its edges lead into the
  // triangle from the edges at b. A corner is on an edge within the rounding.
  bool is_in(Point a, Point b, Point c, Index p) const {
    const Point at = points_[p];
    const double ab = left_of(a, b, at), bc = left_of(b, c, at), ca = left_of(c, a, at);
    if (ab < -rounding_ || bc < -rounding_ || ca < 0) return false;
    // An edge from there into the triangle ends in it.
    if (distance(at, a) <= rounding_ || distance(at, c) <= rounding_) return false;
    if (ab > rounding_ && bc > rounding_) return true;
    const auto leads_in = [&](Index neighbor) {
      const Point to = points_[neighbor];
      return (ab > rounding_ || left_of(a, b, to) > 0) && (bc > rounding_ || left_of(b, c, to) > 0);
    };
    return leads_in(before_[p]) || leads_in(next_[p]);
  }

  const std::vector<Point>& points_;
  double rounding_;
  std::size_t left_;  // corners
  std::vector<Index> next_, before_;
  std::vector<bool> convex_;
  std::vector<Index> others_;  // those that were not convex at first, by x
  DividedFace face_;
};

// Whether all of the other triangle lies beyond an edge of this one, but for the tolerance.
bool is_apart(const std::array<Point, 3>& triangle, const std::array<Point, 3>& other,
              double tolerance) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Point a = triangle[i], b = triangle[(i + 1) % 3];
    const double edge = distance(a, b);
    const auto beyond = [&](Point p) { return turn(a, b, p) <= tolerance * edge; };
    if (std::all_of(other.begin(), other.end(), beyond)) return true;
  }
  return false;
}

// Triangles of positive area that do not overlap show that the polygon winds once around each of
// their points and around no other.
bool overlaps(const std::vector<std::array<Index, 3>>& triangles, const std::vector<Point>& points,
              double tolerance) {
  struct Box {
    std::array<Point, 3> corners;
    double low_x, high_x, low_y, high_y;
  };
  std::vector<Box> boxes;
  for (const auto& [i, j, k] : triangles) {
    const Point a = points[i], b = points[j], c = points[k];
    boxes.push_back({{a, b, c},
                     std::min({a.x, b.x, c.x}),
                     std::max({a.x, b.x, c.x}),
                     std::min({a.y, b.y, c.y}),
                     std::max({a.y, b.y, c.y})});
  }
  std::sort(boxes.begin(), boxes.end(),
            [](const Box& a, const Box& b) { return a.low_x < b.low_x; });
  for (auto one = boxes.begin(); one != boxes.end(); ++one) {
    for (auto two = one + 1; two != boxes.end() && two->low_x < one->high_x; ++two) {
      if (two->low_y >= one->high_y || two->high_y <= one->low_y) continue;
      if (is_apart(one->corners, two->corners, tolerance)) continue;
      if (!is_apart(two->corners, one->corners, tolerance)) return true;
    }
  }
  return false;
}

// Whether every corner turns left and the polygon goes around once.
bool is_convex(const std::vector<Point>& points) {
  const std::size_t count = points.size();
  std::size_t reversals = 0;  // of the direction along x
  double last = 0;
  for (std::size_t i = 0; i < 2 * count; ++i) {
    const Point a = points[i % count], b = points[(i + 1) % count], c = points[(i + 2) % count];
    if (turn(a, b, c) <= 0) return false;
    const double step = b.x - a.x;
    if (step * last < 0) ++reversals;
    if (step != 0) last = step;
  }
  return reversals <= 4;  // two a round
}

DividedFace divide(const std::vector<Point>& points, double rounding, double tolerance) {
  const bool convex = is_convex(points);
  if (convex && points.size() == 4) return {{{0, 1, 2}, {0, 2, 3}}, true};
  DividedFace face = Clipping(points, rounding).run();
  if (!convex && face.simple) face.simple = !overlaps(face.triangles, points, tolerance);
  return face;
}

DividedFace fan(const Corners& corners, bool simple) {
  DividedFace face{{}, simple};
  for (Index i = 2; i < corners.size(); ++i) face.triangles.push_back({0, i - 1, i});
  return face;
}

// Twice the area of the face, along its normal.
Vec3 area_vector(const Corners& corners, double* largest_part) {
  Vec3 sum;
  *largest_part = 0;
  const Vec3 first = to_vec3(corners[0]);
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const Vec3 part = cross(to_vec3(corners[i - 1]) - first, to_vec3(corners[i]) - first);
    *largest_part = std::max(*largest_part, length(part));
    sum = sum + part;
  }
  return sum;
}

// Twice the area of all triangles.
double area_sum(const Corners& corners, const DividedFace& face) {
  double sum = 0;
  for (const auto& [a, b, c] : face.triangles) {
    const Vec3 first = to_vec3(corners[a]);
    sum += length(cross(to_vec3(corners[b]) - first, to_vec3(corners[c]) - first));
  }
  return sum;
}

// The corners along the axis nearest to the normal, which rounds nothing: what is exactly on a line
// stays there.
std::vector<Point> along_axis(const Corners& corners, Vec3 normal) {
  const std::array<double, 3> n = {normal.x, normal.y, normal.z};
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(n[i]) > std::abs(n[axis])) axis = i;
  }
  std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (n[axis] < 0) std::swap(u, v);
  std::vector<Point> points;
  for (const auto& corner : corners) points.push_back({corner[u], corner[v]});
  return points;
}

// The corners along the normal, rounded to floats.
std::vector<Point> along_normal(const Corners& corners, Vec3 normal) {
  const Vec3 up = normalized(normal);
  const Vec3 side = std::abs(up.z) < 0.7 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  const Vec3 u = normalized(cross(side, up)), v = cross(up, u), first = to_vec3(corners[0]);
  std::vector<Point> points;
  for (const auto& corner : corners) {
    const Vec3 p = to_vec3(corner) - first;
    points.push_back({static_cast<float>(dot(p, u)), static_cast<float>(dot(p, v))});
  }
  return points;
}

}  // namespace

DividedFace divide_face(const std::vector<std::array<float, 3>>& corners) {
  if (corners.size() == 3) return fan(corners, true);
  Bounds bounds;
  double largest = 0;
  for (const auto& corner : corners) {
    bounds.add(to_vec3(corner));
    for (const float x : corner) {
      if (!std::isfinite(x)) return fan(corners, true);  // refused later, with its number
      largest = std::max(largest, std::abs(static_cast<double>(x)));
    }
  }
  const Vec3 size = bounds.size();
  const double longest = std::max({size.x, size.y, size.z});
  const double rounding = 2 * std::numeric_limits<float>::epsilon() * largest;
  const double tolerance = std::max(rounding, 1e-5 * longest);
  double largest_part = 0;
  const Vec3 normal = area_vector(corners, &largest_part);
  // On a line, or parts that cancel.
  if (length(normal) <= rounding * longest) {
    return fan(corners, largest_part <= tolerance * longest);
  }
  // Triangles of much more area than the face lie across each other, seen from elsewhere.
  const double most = 2 * length(normal) + tolerance * longest;
  DividedFace face = divide(along_axis(corners, normal), rounding, tolerance);
  face.simple = face.simple && area_sum(corners, face) <= most;
  if (face.simple) return face;
  // A face that is not quite flat may cross itself as seen along the axis alone, and one whose
  // parts touch may cross itself by an error of position.
  DividedFace other = divide(along_normal(corners, normal), tolerance, tolerance);
  return other.simple && area_sum(corners, other) <= most ? other : face;
}

}  // namespace ensonify
