#include "world/heightfield.h"

#include <cmath>

#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "trace/tracer.h"

using namespace ensonify;

namespace {

World terrain(const HeightGrid& grid, Normals normals, const Pose& pose = {}) {
  World world;
  auto mesh = std::make_shared<const Mesh>(heightfield_mesh(grid, normals));
  world.objects.push_back({1, MeshShape{mesh}, pose, {}});
  world.instances.push_back({});
  return world;
}

constexpr double kSlopeX = 0.2, kSlopeY = -0.35, kLevel_m = -4;

HeightGrid tilted_plane() {
  HeightGrid grid{81, 121, 0.25, std::vector<double>(81 * 121)};
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      grid.heights_m[std::size_t(row) * grid.columns + column] =
          kLevel_m + kSlopeX * column_x_m(grid, column) + kSlopeY * row_y_m(grid, row);
    }
  }
  return grid;
}

}  // namespace

// Protects range and incidence over terrain: against the plane's own formula, through any pose.
TEST_CASE("a tilted height grid is hit like its plane") {
  const HeightGrid grid = tilted_plane();
  const Pose pose{{300, -200, 7}, from_roll_pitch_yaw(0.2, -0.1, 2)};
  const Vec3 normal = normalized(Vec3{-kSlopeX, -kSlopeY, 1});
  for (const Normals normals : {Normals::face, Normals::smooth}) {
    const World world = terrain(grid, normals, pose);
    const Tracer tracer(world);
    for (std::uint64_t i = 0; i < 2000; ++i) {
      // From above towards a point of the plane.
      const double x = 28 * (uniform(3, 0, i, 0) - 0.5), y = 18 * (uniform(3, 0, i, 1) - 0.5);
      const Vec3 to{x, y, kLevel_m + kSlopeX * x + kSlopeY * y};
      const Vec3 from{30 * (uniform(3, 0, i, 2) - 0.5), 20 * (uniform(3, 0, i, 3) - 0.5), 6};
      const Vec3 start = transform_point(pose, from), aim = transform_point(pose, to);
      const Hit hit = tracer.first_hit({start, normalized(aim - start)}, 100);
      REQUIRE(hit.instance == 1);
      CHECK(std::abs(hit.range_m - length(to - from)) < 1e-5);
      CHECK(hit.cos_incidence == Approx(std::abs(dot(normal, normalized(to - from)))).margin(1e-5));
    }
  }
}

// Protects coasts and gaps in surveys: a ray passes a hole, and nothing lies beyond the edges.
TEST_CASE("rays pass holes and edges") {
  HeightGrid grid{9, 9, 1, std::vector<double>(81, -5)};
  grid.heights_m[4 * 9 + 4] = std::nan("");
  const World world = terrain(grid, Normals::smooth);
  const Tracer tracer(world);
  const auto hits = [&](double x, double y) {
    return tracer.first_hit({{x, y, 0}, {0, 0, -1}}, 100).instance == 1;
  };
  CHECK_FALSE(hits(0.2, 0.2));
  CHECK_FALSE(hits(-0.2, -0.2));
  CHECK(hits(0.7, 0.7));
  CHECK(hits(-1.2, 0.3));
  CHECK(hits(3.9, -3.9));
  CHECK_FALSE(hits(4.1, 0));
  CHECK_FALSE(hits(0, -4.1));
}
