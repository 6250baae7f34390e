// Faces of many corners: right area, nothing twice, nothing outside, from every first corner.
#include "world/import/polygon.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>

#include "catch.h"
#include "core/vec.h"
#include "random_polygon.h"
#include "world/mesh.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// The plane z = k x + l y, with the axes turned by `axis`: exact in floats.
std::vector<std::array<float, 3>> placed(const Polygon& polygon, std::int64_t k = 0,
                                         std::int64_t l = 0, std::size_t axis = 0) {
  std::vector<std::array<float, 3>> corners;
  for (const Grid p : polygon) {
    const std::array<std::int64_t, 3> xyz = {p.x, p.y, k * p.x + l * p.y};
    corners.push_back({});
    for (std::size_t i = 0; i < 3; ++i) corners.back()[(i + axis) % 3] = static_cast<float>(xyz[i]);
  }
  return corners;
}

double area_of(const std::vector<std::array<float, 3>>& corners, const Triangles& triangles) {
  double sum = 0;
  for (const auto& [a, b, c] : triangles) {
    sum += 0.5 * length(cross(to_vec3(corners[b]) - to_vec3(corners[a]),
                              to_vec3(corners[c]) - to_vec3(corners[a])));
  }
  return sum;
}

// Whether each edge is there once: those within also the other way around, the others are those of
// the polygon. With triangles that turn left this says that they cover a simple polygon once: the
// sum of their outlines is its outline.
bool fill(const Polygon& polygon, const Triangles& triangles) {
  const std::size_t count = polygon.size();
  std::vector<char> edges(count * count);  // from a corner to another
  for (const auto& [a, b, c] : triangles) {
    if (turn_of(polygon[a], polygon[b], polygon[c]) <= 0) return false;
    if (edges[a * count + b]++ + edges[b * count + c]++ + edges[c * count + a]++ > 0) return false;
  }
  std::size_t outer = 0;
  for (const auto& [a, b, c] : triangles) {
    for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
      if (to == (from + 1) % count) {
        ++outer;
      } else if (edges[to * count + from] == 0) {
        return false;
      }
    }
  }
  return outer == count;
}

bool is_beyond_an_edge(const std::array<Grid, 3>& one, const std::array<Grid, 3>& other) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto beyond = [&](Grid p) { return turn_of(one[i], one[(i + 1) % 3], p) <= 0; };
    if (beyond(other[0]) && beyond(other[1]) && beyond(other[2])) return true;
  }
  return false;
}

bool any_overlap(const Polygon& polygon, const Triangles& triangles) {
  const auto at = [&](std::size_t t) {
    return std::array{polygon[triangles[t][0]], polygon[triangles[t][1]], polygon[triangles[t][2]]};
  };
  for (std::size_t s = 0; s < triangles.size(); ++s) {
    for (std::size_t t = 0; t < s; ++t) {
      if (!is_beyond_an_edge(at(s), at(t)) && !is_beyond_an_edge(at(t), at(s))) return true;
    }
  }
  return false;
}

// Whether a point that is on no edge is inside, by crossings of a line to the right. The point is
// three times too large, so that the middle of a triangle is a whole number.
bool is_inside(const Polygon& polygon, Grid p) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Grid a{3 * polygon[i].x, 3 * polygon[i].y};
    const Grid b{3 * polygon[(i + 1) % polygon.size()].x, 3 * polygon[(i + 1) % polygon.size()].y};
    if ((a.y > p.y) == (b.y > p.y)) continue;
    if ((turn_of(a, b, p) > 0) == (b.y > a.y)) inside = !inside;
  }
  return inside;
}

bool all_inside(const Polygon& polygon, const Triangles& triangles) {
  return std::all_of(triangles.begin(), triangles.end(), [&](const auto& t) {
    const Grid a = polygon[t[0]], b = polygon[t[1]], c = polygon[t[2]];
    return is_inside(polygon, {a.x + b.x + c.x, a.y + b.y + c.y});
  });
}

Polygon from_corner(const Polygon& polygon, std::size_t first) {
  Polygon turned = polygon;
  std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(first), turned.end());
  return turned;
}

// What is wrong with the triangles of a simple polygon in its own plane; empty if nothing.
std::string wrong_with(const Polygon& polygon) {
  const DividedFace face = divide_face(placed(polygon));
  if (!face.simple) return "taken for crossing itself";
  if (!fill(polygon, face.triangles)) return "not filled once";
  return {};
}

// The same for one that touches itself.
std::string wrong_with_touching(const Polygon& polygon) {
  const auto corners = placed(polygon);
  const DividedFace face = divide_face(corners);
  if (!face.simple) return "taken for crossing itself";
  const double wanted = 0.5 * static_cast<double>(shoelace(polygon));
  if (std::abs(area_of(corners, face.triangles) - wanted) > 1e-6 * wanted) return "area";
  if (any_overlap(polygon, face.triangles)) return "overlap";
  if (!all_inside(polygon, face.triangles)) return "outside";
  return {};
}

std::string text_of(const Polygon& polygon) {
  std::string text;
  for (const Grid p : polygon) text += "(" + std::to_string(p.x) + "," + std::to_string(p.y) + ") ";
  return text;
}

// From every first corner, in both windings.
void check_everywhere(const Polygon& polygon, std::string (*wrong)(const Polygon&)) {
  for (std::size_t first = 0; first < polygon.size(); ++first) {
    const Polygon turned = from_corner(polygon, first);
    const std::string why = wrong(turned);
    if (!why.empty()) FAIL_CHECK(why << ": " << text_of(turned));
  }
}

std::vector<Polygon> touching_polygons() {
  const Polygon bridge = {{0, 0}, {9, 0}, {9, 9}, {0, 9}, {0, 0},
                          {3, 3}, {3, 6}, {6, 6}, {6, 3}, {3, 3}};
  const Polygon two_holes = {{0, 0},  {20, 0}, {20, 9}, {0, 9},  {0, 0},  {3, 3}, {3, 6}, {6, 6},
                             {12, 6}, {15, 6}, {15, 3}, {12, 3}, {12, 6}, {6, 6}, {6, 3}, {3, 3}};
  const Polygon tip_inside = {{0, 0}, {8, 0}, {8, 8}, {5, 8},
                              {4, 0}, {3, 8}, {0, 8}};  // a notch down to the far edge
  const Polygon tip_in_corner = {{0, 0}, {8, 0}, {8, 8}, {4, 6}, {0, 0}, {2, 8}, {0, 8}};
  const Polygon ring = {{0, 0}, {9, 0}, {9, 9}, {0, 9}, {0, 1}, {1, 1},
                        {1, 8}, {8, 8}, {8, 1}, {0, 1}, {0, 0}};  // closes on itself
  const Polygon pinch = {{0, 0}, {4, 0}, {2, 2},
                         {4, 4}, {0, 4}, {2, 2}};  // two triangles at a point
  const Polygon antenna = {{0, 0}, {4, 0}, {4, 4}, {7, 7}, {4, 4}, {0, 4}};
  const Polygon inner_antenna = {{0, 0}, {4, 0}, {4, 4}, {1, 0}, {4, 4}, {0, 4}};
  const Polygon corner_twice = {{0, 0}, {4, 0}, {4, 0}, {4, 4}, {0, 4}};
  return {bridge, two_holes, tip_inside,    tip_in_corner, ring,
          pinch,  antenna,   inner_antenna, corner_twice};
}

// Random polygons; those of every first corner are checked with each of theirs.
void check_random(std::uint32_t seed, int count, int with_every_corner) {
  std::mt19937 random(seed);
  std::size_t corners = 0;
  for (int n = 0; n < count; ++n) {
    const Polygon polygon = random_polygon(random, 3 + random() % 198);
    corners += polygon.size();
    const std::string why = wrong_with(polygon);
    if (!why.empty()) FAIL_CHECK(why << ": " << text_of(polygon));
    // The area in space, in a tilted plane along each axis.
    const std::int64_t k = whole(random, -9, 9), l = whole(random, -9, 9);
    const auto space = placed(polygon, k, l, random() % 3);
    const double wanted = 0.5 * std::abs(static_cast<double>(shoelace(polygon))) *
                          std::sqrt(1.0 + static_cast<double>(k * k + l * l));
    const DividedFace face = divide_face(space);
    if (!face.simple || std::abs(area_of(space, face.triangles) - wanted) > 1e-6 * wanted) {
      FAIL_CHECK("tilted by " << k << " " << l << ": " << text_of(polygon));
    }
    if (n < with_every_corner) check_everywhere(polygon, wrong_with);
    if (n % 16 == 0 && any_overlap(polygon, divide_face(placed(polygon)).triangles)) {
      FAIL_CHECK("overlap: " << text_of(polygon));
    }
  }
  CHECK(corners > static_cast<std::size_t>(count) * 50);  // they do grow
}

}  // namespace

TEST_CASE("random simple polygons are filled once", "[figure]") { check_random(1, 1000, 50); }

TEST_CASE("10,000 random simple polygons are filled once, 500 from every first corner", "[rest]") {
  check_random(2, 10'000, 500);
}

TEST_CASE("sections of beams, stairs and corners on edges or diagonals are filled once") {
  const Polygon h = {{-15, -15}, {15, -15}, {15, -12}, {2, -12}, {2, 12},   {15, 12},
                     {15, 15},   {-15, 15}, {-15, 12}, {-2, 12}, {-2, -12}, {-15, -12}};
  const Polygon l = {{0, 0}, {6, 0}, {6, 1}, {1, 1}, {1, 6}, {0, 6}};
  const Polygon arrow = {{0, 0}, {4, 2}, {0, 4}, {1, 2}};
  const Polygon quad_with_flat_corner = {{0, 0}, {2, 0}, {4, 0}, {0, 3}};
  const Polygon on_diagonal = {
      {0, 0}, {6, 0}, {6, 6}, {3, 3}, {0, 6}};  // a notch down to its diagonal
  Polygon stairs = {{20, 0}, {20, 20}};
  for (std::int64_t i = 20; i > 0; --i) {
    stairs.push_back({i - 1, i});
    stairs.push_back({i - 1, i - 1});
  }
  Polygon square;  // with corners on its edges
  for (std::int64_t i = 0; i < 5; ++i) square.push_back({i, 0});
  for (std::int64_t i = 0; i < 5; ++i) square.push_back({5, i});
  for (std::int64_t i = 5; i > 0; --i) square.push_back({i, 5});
  for (std::int64_t i = 5; i > 0; --i) square.push_back({0, i});
  Polygon comb = {{0, -1}, {41, -1}};
  for (std::int64_t i = 20; i >= 0; --i) {
    comb.push_back({2 * i + 1, 50});
    comb.push_back({2 * i, 0});
  }
  for (const Polygon& polygon :
       {h, l, arrow, quad_with_flat_corner, on_diagonal, stairs, square, comb}) {
    check_everywhere(polygon, wrong_with);
  }
}

TEST_CASE("bridges to holes and parts that touch are no crossings") {
  for (const Polygon& polygon : touching_polygons()) check_everywhere(polygon, wrong_with_touching);
}

// Holes cut into triangles of a random polygon, each on a bridge from a corner or touching it.
TEST_CASE("random polygons with holes are filled once") {
  std::mt19937 random(3);
  for (int n = 0; n < 150; ++n) {
    Polygon polygon = random_polygon(random, 3 + random() % 60);
    for (Grid& p : polygon) p = {12 * p.x, 12 * p.y};
    std::map<std::uint32_t, Polygon> holes;  // by the corner that they hang on
    for (const auto& [a, b, c] : divide_face(placed(polygon)).triangles) {
      if (random() % 3 != 0) continue;
      const Grid p = polygon[a], q = polygon[b], r = polygon[c];
      const auto at = [&](std::int64_t u, std::int64_t v) {  // twelfths of the edges
        return Grid{p.x + (u * (q.x - p.x) + v * (r.x - p.x)) / 12,
                    p.y + (u * (q.y - p.y) + v * (r.y - p.y)) / 12};
      };
      const Polygon touching = {at(2, 7), at(7, 2), p};
      const Polygon bridged = {at(2, 2), at(2, 7), at(7, 2), at(2, 2), p};
      holes[a] = random() % 2 == 0 ? touching : bridged;
    }
    Polygon whole_face;
    for (std::uint32_t i = 0; i < polygon.size(); ++i) {
      whole_face.push_back(polygon[i]);
      if (const auto hole = holes.find(i); hole != holes.end()) {
        whole_face.insert(whole_face.end(), hole->second.begin(), hole->second.end());
      }
    }
    const Polygon turned = from_corner(whole_face, random() % whole_face.size());
    const std::string why = wrong_with_touching(turned);
    if (!why.empty()) FAIL_CHECK(why << ": " << text_of(turned));
  }
}

// In planes of any direction, where corners on an edge are beside it by the rounding.
TEST_CASE("faces that are not quite flat keep their area") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> angle(-3, 3), noise(-1e-5, 1e-5), in_plane(-3e-6, 3e-6);
  std::vector<Polygon> polygons;
  for (int n = 0; n < 300; ++n) polygons.push_back(random_polygon(random, 3 + random() % 60));
  for (int n = 0; n < 20; ++n) {
    const auto more = touching_polygons();
    polygons.insert(polygons.end(), more.begin(), more.end());
  }
  for (const Polygon& polygon : polygons) {
    std::int64_t largest = 0;
    for (const Grid p : polygon) largest = std::max({largest, p.x, p.y});
    const double scale = 1 / static_cast<double>(largest);
    const Quat turn = from_roll_pitch_yaw(angle(random), angle(random), angle(random));
    std::vector<std::array<float, 3>> corners;
    for (const Grid p : polygon) {
      const Vec3 flat{scale * static_cast<double>(p.x), scale * static_cast<double>(p.y), 0};
      corners.push_back(
          to_floats(rotate(turn, flat + Vec3{in_plane(random), in_plane(random), noise(random)})));
    }
    const double wanted = 0.5 * scale * scale * static_cast<double>(shoelace(polygon));
    const DividedFace face = divide_face(corners);
    INFO(text_of(polygon));
    CHECK(face.simple);
    CHECK(std::abs(area_of(corners, face.triangles) - wanted) < 1e-4 * wanted + 1e-5);
  }
}

// A slit of 5 cm between corners that are 10 cm off the plane y = z, to one side and the other:
// seen along an axis its edges cross.
TEST_CASE("a face that is far from flat is seen along its normal") {
  const std::vector<Vec3> flat = {{0, 0, 0},      {8, 0, 0},      {8, 4, -0.1}, {1, 4, -0.1},
                                  {1, 4.05, 0.1}, {8, 4.05, 0.1}, {8, 8, 0},    {0, 8, 0}};
  const Quat turn = from_roll_pitch_yaw(std::acos(-1.0) / 4, 0, 0);
  std::vector<std::array<float, 3>> corners;
  for (const Vec3 p : flat) corners.push_back(to_floats(rotate(turn, p)));
  for (std::size_t first = 0; first < corners.size(); ++first) {
    std::rotate(corners.begin(), corners.begin() + 1, corners.end());
    const DividedFace face = divide_face(corners);
    CHECK(face.simple);
    CHECK(area_of(corners, face.triangles) == Approx(64 - 7 * 0.05).epsilon(0.02));
  }
}

TEST_CASE("a face that crosses itself is told") {
  const Polygon bow_tie = {{0, 0}, {4, 4}, {4, 0}, {0, 4}};
  const Polygon uneven_bow_tie = {{0, 0}, {8, 0}, {2, 4}, {6, 4}};
  const Polygon pentagram = {{0, 10}, {6, -8}, {-10, 3}, {10, 3}, {-6, -8}};
  const Polygon twice_around = {{0, 0}, {9, 0}, {9, 9}, {0, 9}, {0, 0}, {9, 0}, {9, 9}, {0, 9}};
  const Polygon inner_loop = {{0, 0}, {9, 0}, {9, 9}, {4, 4}, {4, 6}, {6, 6}, {6, 2}, {0, 9}};
  const Polygon loop_at_a_corner = {{0, 0}, {9, 0}, {9, 9}, {0, 9}, {0, 0}, {4, 1}, {4, 4}};
  for (const Polygon& polygon :
       {bow_tie, uneven_bow_tie, pentagram, twice_around, inner_loop, loop_at_a_corner}) {
    for (std::size_t first = 0; first < polygon.size(); ++first) {
      INFO(text_of(from_corner(polygon, first)));
      CHECK_FALSE(divide_face(placed(from_corner(polygon, first))).simple);
    }
  }
}

// Out and back twice, a hair apart: seen from the side it is a simple polygon.
TEST_CASE("a face of two spikes is no sheet between them") {
  for (const float hair : {1e-5f, 3e-5f, 1e-4f, 1e-3f}) {
    std::vector<std::array<float, 3>> corners = {
        {-15, -15, 0}, {15, -15, 0.4f * hair}, {-15, -15, hair}, {-13, 0, 0}};
    for (int first = 0; first < 4; ++first) {
      std::rotate(corners.begin(), corners.begin() + 1, corners.end());
      const DividedFace face = divide_face(corners);
      CHECK((!face.simple || area_of(corners, face.triangles) < 1));
    }
  }
}

TEST_CASE("a face without area or with numbers that are not finite ends") {
  CHECK(divide_face(placed({{0, 0}, {1, 0}, {2, 0}, {3, 0}})).simple);
  CHECK(divide_face(placed({{1, 1}, {1, 1}, {1, 1}, {1, 1}})).triangles.size() == 2);
  auto corners = placed({{0, 0}, {5, 0}, {5, 5}, {2, 2}, {0, 5}});
  corners[2][1] = std::numeric_limits<float>::quiet_NaN();
  CHECK(divide_face(corners).triangles.size() == 3);
}
