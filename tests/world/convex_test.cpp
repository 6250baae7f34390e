// Convex hulls, the faces that a body can lie on, and gaps between outlines.
#include "world/convex.h"

#include <cmath>

#include "catch.h"
#include "core/units.h"
#include "world/outline.h"

using namespace ensonify;

namespace {

std::vector<Vec3> box_points(Vec3 half) { return contact_points(BoxShape{half}); }

double solid_angle_of_rectangle(double a, double b, double distance) {
  return 4 * std::atan(a * b / (distance * std::sqrt(a * a + b * b + distance * distance)));
}

Outline box_at(double x, double y, double yaw_deg, double half_x, double half_y) {
  const Quat turn = from_roll_pitch_yaw(0, 0, radians(yaw_deg));
  return moved(outline_of(BoxShape{{half_x, half_y, 1}}, turn), {x, y, 0});
}

Outline ball_at(double x, double y, double radius) {
  return moved(outline_of(SphereShape{radius}, {}), {x, y, 0});
}

}  // namespace

TEST_CASE("a hull has the corners alone, counter-clockwise") {
  const auto hull = convex_hull({{0, 0}, {1, 0}, {0.5, 0}, {1, 1}, {0, 1}, {0.5, 0.5}, {0, 0}});
  CHECK(hull == std::vector<Point2>{{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  CHECK(convex_hull({{2, 2}, {0, 0}, {1, 1}}) == std::vector<Point2>{{0, 0}, {2, 2}});
  CHECK(convex_hull({{3, 4}, {3, 4}}) == std::vector<Point2>{{3, 4}});
}

// Protects how bodies come to lie: a box rests on each of its faces as often as the solid angle of the
// face says, seen from its middle.
TEST_CASE("a box rests on its six faces") {
  const Vec3 half{0.5, 0.4, 0.1};
  const auto faces = rest_faces(box_points(half));
  REQUIRE(faces.ok());
  REQUIRE(faces->size() == 6);
  double sum = 0;
  for (const RestFace& face : *faces) {
    sum += face.share;
    const Vec3 n = face.normal;
    const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    CHECK(std::max({x, y, z}) > 1 - 1e-12);
    const double angle = z > 0.5   ? solid_angle_of_rectangle(half.x, half.y, half.z)
                         : y > 0.5 ? solid_angle_of_rectangle(half.x, half.z, half.y)
                                   : solid_angle_of_rectangle(half.y, half.z, half.x);
    CHECK(std::abs(face.share - angle / (4 * kPi)) < 1e-9);
  }
  CHECK(std::abs(sum - 1) < 1e-12);
}

// Protects against bodies that stand where they would fall: a pyramid that leans over lies on those
// faces over which its centre of mass is.
TEST_CASE("a leaning pyramid does not rest on its base") {
  const std::vector<Vec3> pyramid{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {6, 0, 2}};
  const auto faces = rest_faces(pyramid);
  REQUIRE(faces.ok());
  // A quarter of the height above the middle of the base, a quarter of the way to the tip.
  const Vec3 centre{1.5, 0, 0.5};
  for (const RestFace& face : *faces) {
    CHECK(face.normal.z > -0.99);
    double height = -1e9;
    for (const Vec3& point : pyramid) height = std::max(height, dot(point, face.normal));
    CHECK(dot(centre, face.normal) < height);
  }
}

TEST_CASE("points of one plane have no face to rest on") {
  CHECK_FALSE(rest_faces({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.3, 0.2, 0}}).ok());
  CHECK_FALSE(rest_faces({{0, 0, 0}, {1, 0, 0}}).ok());
}

// Protects the clearance: gaps of boxes and balls in closed form, on faces, at corners, and below zero
// where they overlap; from either side the same, in opposite directions.
TEST_CASE("gaps between outlines are those of plane geometry") {
  struct Case {
    Outline a, b;
    double distance, x, y;
  };
  const double diagonal = std::sqrt(0.5);
  const Case cases[] = {
      {box_at(0, 0, 0, 1, 1), box_at(3, 0.5, 0, 1, 1), 1, 1, 0},
      {box_at(0, 0, 0, 1, 1), box_at(3, 3, 0, 1, 1), std::sqrt(2), diagonal, diagonal},
      {box_at(0, 0, 0, 1, 1), box_at(3, 0, 45, 1, 1), 2 - std::sqrt(2), 1, 0},
      {box_at(0, 0, 0, 1, 1), box_at(1.5, 0, 0, 1, 1), -0.5, 1, 0},
      {box_at(0, 0, 0, 1, 1), ball_at(0, -3, 0.5), 1.5, 0, -1},
      {box_at(0, 0, 0, 1, 1), ball_at(2, 2, 1), std::sqrt(2) - 1, diagonal, diagonal},
      {box_at(0, 0, 0, 1, 1), ball_at(1.25, 0, 0.5), -0.25, 1, 0},
      {ball_at(0, 0, 1), ball_at(0, 5, 2), 2, 0, 1},
      {ball_at(1, 1, 1), ball_at(1, 1, 2), -3, 1, 0},
  };
  for (const Case& of : cases) {
    const Gap gap = gap_between(of.a, of.b), back = gap_between(of.b, of.a);
    CHECK(std::abs(gap.distance_m - of.distance) < 1e-12);
    CHECK(std::abs(back.distance_m - of.distance) < 1e-12);
    CHECK(std::hypot(gap.x - of.x, gap.y - of.y) < 1e-12);
    if (of.distance > -3) CHECK(std::hypot(back.x + of.x, back.y + of.y) < 1e-12);
  }
}

TEST_CASE("a turned outline is that of the turned body") {
  const BoxShape box{{2, 0.5, 0.3}};
  const Quat lying = from_roll_pitch_yaw(0.3, 0.2, 0), yaw = from_roll_pitch_yaw(0, 0, 0.7);
  const Outline once = outline_of(box, yaw * lying), twice = turned(outline_of(box, lying), 0.7);
  CHECK(std::abs(once.x_m - twice.x_m) < 1e-12);
  CHECK(std::abs(once.radius_m - twice.radius_m) < 1e-12);
  CHECK(std::abs(once.high_m - twice.high_m) < 1e-12);
  REQUIRE(once.hull_m.size() == twice.hull_m.size());
  CHECK(std::abs(gap_between(once, moved(twice, {10, 0, 0})).distance_m -
                 gap_between(once, moved(once, {10, 0, 0})).distance_m) < 1e-12);
}
