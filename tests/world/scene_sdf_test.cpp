#include "world/scene_sdf.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <functional>
#include <random>

#include "catch.h"
#include "is_refused.h"
#include "temporary_folder.h"
#include "world/terrain.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

const SdfRegion kRegion{{-2, -2, -1.5}, {2, 2, 1.5}};
const SdfGrid kGrid{0.05, 3};

World world_of(const std::vector<std::pair<Shape, Pose>>& objects) {
  World world;
  for (const auto& [shape, pose] : objects) {
    world.objects.push_back(
        {static_cast<std::uint32_t>(world.objects.size() + 1), shape, pose, {}});
  }
  return world;
}

std::vector<Pose> poses_of(const World& world) {
  std::vector<Pose> poses;
  for (const WorldObject& object : world.objects) poses.push_back(object.pose);
  return poses;
}

std::string bytes_of(const World& world, const SdfGrid& grid = kGrid,
                     const SdfRegion& region = kRegion) {
  const auto bytes = scene_sdf_vdb(world, poses_of(world), grid, region);
  INFO((bytes ? "" : bytes.error().message));
  REQUIRE(bytes.ok());
  return *bytes;
}

// OpenVDB would start threads to count and to free, which the thread sanitizer cannot follow.
template <class Work>
auto on_one_thread(Work work) {
  return tbb::task_arena(1).execute(work);
}

// Through a file, as others read it.
openvdb::FloatGrid::Ptr grid_of(const std::string& bytes) {
  openvdb::initialize();
  const TemporaryFolder folder;
  openvdb::io::File file(folder.write("sdf.vdb", bytes).string());
  file.open(false);
  REQUIRE(file.hasGrid("sdf"));
  auto grid =
      openvdb::gridPtrCast<openvdb::FloatGrid>(on_one_thread([&] { return file.readGrid("sdf"); }));
  return {grid.get(),
          [grid](openvdb::FloatGrid*) mutable { on_one_thread([&] { grid.reset(); }); }};
}

double active_voxels(const openvdb::FloatGrid& grid) {
  return double(on_one_thread([&] { return grid.activeVoxelCount(); }));
}

openvdb::FloatGrid::Ptr grid_of(const World& world) { return grid_of(bytes_of(world)); }

using Distance = std::function<double(Vec3)>;

// Every voxel of the region against the distance at its middle: within `margin` of it and active
// inside the band, +- the band's width and inactive beyond. Tells how many were active. `distance`
// is asked for positions from `origin`.
int check_voxels(const openvdb::FloatGrid& grid, const Distance& distance, double margin_m,
                 openvdb::Coord origin = {}) {
  const double band = kGrid.voxel_m * kGrid.band_voxels;
  auto voxels = grid.getConstAccessor();
  int active = 0;
  double worst = 0;
  for (int x = -40; x <= 40; ++x) {
    for (int y = -40; y <= 40; ++y) {
      for (int z = -30; z <= 30; ++z) {
        float value = 0;
        const bool on = voxels.probeValue(origin.offsetBy(x, y, z), value);
        const double d = distance(kGrid.voxel_m * Vec3{double(x), double(y), double(z)});
        active += on;
        worst = std::max(worst, std::abs(value - std::clamp(d, -band, band)));
        if (std::abs(std::abs(d) - band) > margin_m) REQUIRE(on == (std::abs(d) < band));
      }
    }
  }
  CHECK(worst <= margin_m);
  return active;
}

double box_distance(Vec3 p, Vec3 half) {
  const Vec3 q{std::abs(p.x) - half.x, std::abs(p.y) - half.y, std::abs(p.z) - half.z};
  return std::hypot(std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)) +
         std::min(std::max({q.x, q.y, q.z}), 0.0);
}

Mesh box_mesh(float x, float y, float z) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back({i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z});
  }
  for (const auto& q : {std::array<std::uint32_t, 4>{0, 2, 3, 1},
                        {4, 5, 7, 6},
                        {0, 1, 5, 4},
                        {2, 6, 7, 3},
                        {0, 4, 6, 2},
                        {1, 3, 7, 5}}) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

const Pose kTurned{{0.2, -0.9, 0.1}, from_roll_pitch_yaw(0.3, 0.5, 0.7)};

}  // namespace

// Protects the ground truth: the distance at every voxel is the least of the closed forms', to
// float's rounding, and between voxels within a tenth of one.
TEST_CASE("the field of closed forms is their least distance") {
  const Pose ball{{0.3, 0.9, -0.2}, {}}, floor{{0, 0, -0.8}, from_roll_pitch_yaw(0.1, 0, 0)};
  const World world = world_of({{SphereShape{0.5, false}, ball},
                                {BoxShape{{0.5, 0.3, 0.4}, false}, kTurned},
                                {PlaneShape{}, floor},
                                {CylinderShape{0.2, 0.4}, {{-1.2, 0.5, 0.3}, kTurned.rotation}}});
  const Distance distance = [&](Vec3 p) {
    const Vec3 c = inverse_transform_point({{-1.2, 0.5, 0.3}, kTurned.rotation}, p);
    const double side = std::hypot(c.x, c.y) - 0.2, end = std::abs(c.z) - 0.4;
    const double cylinder =
        std::hypot(std::max(side, 0.0), std::max(end, 0.0)) + std::min(std::max(side, end), 0.0);
    return std::min({length(p - ball.position_m) - 0.5, cylinder,
                     box_distance(inverse_transform_point(kTurned, p), {0.5, 0.3, 0.4}),
                     dot(p - floor.position_m, rotate(floor.rotation, {0, 0, 1}))});
  };
  const auto grid = grid_of(world);
  CHECK(grid->getGridClass() == openvdb::GRID_LEVEL_SET);
  CHECK(grid->voxelSize() == openvdb::Vec3d(0.05));
  CHECK(check_voxels(*grid, distance, 1e-6) > 30'000);

  const openvdb::tools::GridSampler<openvdb::FloatGrid, openvdb::tools::BoxSampler> field(*grid);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  double worst = 0;
  int points = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 out = normalized(Vec3{unit(random), unit(random), unit(random)});
    // All eight voxels around stay within the band and nearest to the ball.
    const double exact = 0.05 * unit(random);
    const Vec3 p = ball.position_m + (0.5 + exact) * out;
    const double others =
        std::min({dot(p - floor.position_m, rotate(floor.rotation, {0, 0, 1})),
                  box_distance(inverse_transform_point(kTurned, p), {0.5, 0.3, 0.4})});
    if (others < exact + 0.2) continue;
    ++points;
    worst = std::max(worst, std::abs(field.wsSample({p.x, p.y, p.z}) - exact));
  }
  CHECK(worst < 0.1 * kGrid.voxel_m);
  CHECK(points > 500);
}

TEST_CASE("rooms are solid outside") {
  const World world = world_of({{BoxShape{{1.4, 1.2, 1}, true}, {}}});
  check_voxels(
      *grid_of(world),
      [](Vec3 p) {
        return -box_distance(p, {1.4, 1.2, 1});
      },
      1e-6);
}

// Protects meshes and models: a box of triangles is the box, on both sides.
TEST_CASE("the field of a closed mesh is that of its body") {
  const auto mesh = std::make_shared<const Mesh>(box_mesh(0.5f, 0.3f, 0.4f));
  const World world = world_of({{MeshShape{mesh}, kTurned}, {SphereShape{0.4, false}, {}}});
  const Distance distance = [&](Vec3 p) {
    return std::min(box_distance(inverse_transform_point(kTurned, p), {0.5, 0.3, 0.4}),
                    length(p) - 0.4);
  };
  CHECK(check_voxels(*grid_of(world), distance, 1e-4) > 10'000);

  // Coordinates of maps are large: a float's step is a millimetre here, in voxels and in metres.
  const openvdb::Coord far(400'000, -400'000, 0);
  const Vec3 far_m = kGrid.voxel_m * Vec3{double(far.x()), double(far.y()), 0};
  World moved = world;
  for (WorldObject& object : moved.objects) object.pose.position_m = object.pose.position_m + far_m;
  const SdfRegion region{kRegion.low_m + far_m, kRegion.high_m + far_m};
  const auto grid = grid_of(bytes_of(moved, kGrid, region));
  CHECK(check_voxels(*grid, distance, 1e-4, far) > 10'000);
}

// Protects terrain: solid below its surface down to the region's end, without a floor of its own.
TEST_CASE("terrain is a block of ground", "[figure]") {
  HeightGrid heights{41, 41, 0.15, std::vector<double>(41 * 41, 0.0)};
  for (int r = 0; r < 41; ++r) {
    for (int c = 0; c < 41; ++c) heights.heights_m[r * 41 + c] = 0.2 * column_x_m(heights, c);
  }
  const auto mesh = std::make_shared<const Mesh>(heightfield_mesh(heights, Normals::face));
  const Pose pose{{0, 0, -0.5}, {}};
  const World world = world_of({{MeshShape{mesh, true}, pose}});
  const double cosine = 1 / std::hypot(1, 0.2);
  check_voxels(
      *grid_of(world), [&](Vec3 p) { return (p.z + 0.5 - 0.2 * p.x) * cosine; }, 1e-4);
}

TEST_CASE("a mesh that is not closed is unsigned") {
  Mesh sheet;
  sheet.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const World world = world_of({{MeshShape{std::make_shared<const Mesh>(sheet)}, {}}});
  check_voxels(
      *grid_of(world),
      [](Vec3 p) {
        return std::hypot(std::max(std::abs(p.x) - 1, 0.0), std::max(std::abs(p.y) - 1, 0.0), p.z);
      },
      1e-4);
}

// Protects the promise of equal bytes: OpenVDB would tag every file anew.
TEST_CASE("equal scenes give equal bytes") {
  const auto mesh = std::make_shared<const Mesh>(box_mesh(0.5f, 0.3f, 0.4f));
  const World world = world_of({{MeshShape{mesh}, kTurned}, {PlaneShape{}, {{0, 0, -1}, {}}}});
  const std::string first = bytes_of(world), second = bytes_of(world);
  CHECK(first == second);
  CHECK(first.find("00000000-0000-0000-0000-000000000000") == 21);
  const World empty;
  CHECK(active_voxels(*grid_of(empty)) == 0);
}

// Protects the machine, and says what would fit.
TEST_CASE("a field of too many voxels is refused") {
  const World world = world_of({{PlaneShape{}, {}}});
  const auto fine = scene_sdf_vdb(world, poses_of(world), {1e-5, 3}, kRegion);
  CHECK(is_refused(fine, "m or more", ErrorKind::usage));
  const World none;
  const auto far = scene_sdf_vdb(none, {}, {1e-3, 3}, {{9e6, 0, 0}, {9e6, 1, 1}});
  CHECK(is_refused(far, "2^30 voxels"));
  const SdfSize size = sdf_size(world, poses_of(world), kGrid, kRegion);
  const double active = active_voxels(*grid_of(world));
  CHECK(size.voxels > active);
  CHECK(size.voxels < 2.5 * active);
}
