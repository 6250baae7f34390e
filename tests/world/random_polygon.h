// Random simple polygons.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace ensonify::test {

// Corners on a grid of whole numbers, where every test of the place of a point is exact.
struct Grid {
  std::int64_t x = 0, y = 0;
  friend bool operator==(const Grid&, const Grid&) = default;
};
using Polygon = std::vector<Grid>;

inline std::int64_t turn_of(Grid a, Grid b, Grid c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Twice the area, by the shoelace formula.
inline std::int64_t shoelace(const Polygon& polygon) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Grid a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    sum += a.x * b.y - a.y * b.x;
  }
  return sum;
}

inline bool is_on_edge(Grid a, Grid b, Grid p) {
  return turn_of(a, b, p) == 0 && p.x >= std::min(a.x, b.x) && p.x <= std::max(a.x, b.x) &&
         p.y >= std::min(a.y, b.y) && p.y <= std::max(a.y, b.y);
}

inline int sign_of(std::int64_t value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

// Whether two edges share a point.
inline bool meet(Grid a, Grid b, Grid c, Grid d) {
  if (std::max(a.x, b.x) < std::min(c.x, d.x) || std::max(c.x, d.x) < std::min(a.x, b.x)) {
    return false;
  }
  if (is_on_edge(a, b, c) || is_on_edge(a, b, d) || is_on_edge(c, d, a) || is_on_edge(c, d, b)) {
    return true;
  }
  return sign_of(turn_of(a, b, c)) * sign_of(turn_of(a, b, d)) < 0 &&
         sign_of(turn_of(c, d, a)) * sign_of(turn_of(c, d, b)) < 0;
}

// Whether p can be put between corner i and the next, so that the polygon stays simple.
inline bool fits(const Polygon& polygon, std::size_t i, Grid p) {
  const std::size_t count = polygon.size(), j = (i + 1) % count;
  const Grid a = polygon[i], b = polygon[j];
  for (std::size_t k = 0; k < count; ++k) {
    const Grid c = polygon[k], d = polygon[(k + 1) % count];
    if (k == i) {
      if (p == a || p == b || is_on_edge(a, p, b) || is_on_edge(b, p, a)) return false;
    } else {
      if (d == a ? is_on_edge(c, d, p) || is_on_edge(a, p, c) : meet(c, d, a, p)) return false;
      if (c == b ? is_on_edge(c, d, p) || is_on_edge(b, p, d) : meet(c, d, p, b)) return false;
    }
  }
  return true;
}

inline std::int64_t whole(std::mt19937& random, std::int64_t low, std::int64_t high) {
  return low + static_cast<std::int64_t>(random() % static_cast<std::uint32_t>(high - low + 1));
}

// Grows from a triangle by corners put into its edges: near them, far away, or on them.
inline Polygon random_polygon(std::mt19937& random, std::size_t corners) {
  const std::int64_t size = random() % 2 == 0 ? 300 : 60;  // the small grid has many lines
  Polygon polygon = {{0, 0}, {size, 0}, {whole(random, 0, size), size}};
  for (int tries = 0; polygon.size() < corners && tries < 3000; ++tries) {
    const std::size_t i = random() % polygon.size();
    const Grid a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    const std::int64_t reach =
        random() % 4 == 0 ? size : 1 + std::max(std::abs(b.x - a.x), std::abs(b.y - a.y));
    Grid p{(a.x + b.x) / 2 + whole(random, -reach, reach),
           (a.y + b.y) / 2 + whole(random, -reach, reach)};
    if (random() % 8 == 0) p = {(a.x + b.x) / 2, (a.y + b.y) / 2};
    if (fits(polygon, i, p))
      polygon.insert(polygon.begin() + static_cast<std::ptrdiff_t>(i) + 1, p);
  }
  if (shoelace(polygon) < 0)
    std::reverse(polygon.begin(), polygon.end());  // it was turned inside out
  return polygon;
}

}  // namespace ensonify::test
