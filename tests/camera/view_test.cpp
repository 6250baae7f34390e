// Images of a camera against closed forms, by mounts that are turned and stand aside.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include "camera/color.h"
#include "camera/flow.h"
#include "catch.h"
#include "core/camera_planes.h"
#include "ping/camera.h"
#include "ping/run_scene.h"
#include "temporary_folder.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr double kDegree = std::numbers::pi / 180;

// Sonar and camera are apart and turned on a body that is itself elsewhere.
std::string scene(const std::string& objects, const std::string& camera = "",
                  const std::string& rest = "") {
  return R"(ensonify: 1
name: camera
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 8
  beams: {count: 8, fov_deg: 24}
  rays: {elevation: 6, azimuth: 1, min_per_cell: 0}
  mount: {position_m: [0.3, 0.1, -0.2], rotation_deg: [0, 10, 5]}
camera:
  mount: {position_m: [0.2, -0.3, 0.1], rotation_deg: [3, 20, -8]}
  width_px: 161
  height_px: 121
  focal_px: [110, 112]
  distortion: {k1: -0.2, k2: 0.05, p1: 0.001, p2: -0.002}
)" + camera +
         R"(materials: {m: {reflectivity: 1e-3, color: [0.8, 0.5, 0.2]}}
output: {polar: false, cartesian: false, png: false, timeseries: none, camera: {flow: true}}
)" +
         (rest.empty()
              ? "trajectory: {poses: [{position_m: [2, 3, -5], rotation_deg: [4, -6, 70]}]}\n"
              : rest) +
         "objects:\n" + objects;
}

struct Shot {
  explicit Shot(const std::string& text, std::uint32_t ping = 0)
      : run(SceneRun::of_text(text)),
        camera(*run.info().camera),
        pose(camera_pose(run.session(), camera, ping)),
        view(*run.ping(ping).camera) {}

  std::size_t at(int row, int column) const { return std::size_t(row) * view.columns + column; }
  // Of the world, in the frame of the camera.
  Vec3 seen(Vec3 world) const { return inverse_transform_point(pose, world); }

  SceneRun run;
  Camera camera;
  Pose pose;
  CameraView view;
};

// The axes of the camera in the world by rotation matrices: yaw, pitch, roll of body and mount.
Vec3 turned_by(const std::array<double, 3>& rpy_deg, Vec3 v) {
  const auto [roll, pitch, yaw] = rpy_deg;
  const double cr = std::cos(roll * kDegree), sr = std::sin(roll * kDegree);
  const double cp = std::cos(pitch * kDegree), sp = std::sin(pitch * kDegree);
  const double cy = std::cos(yaw * kDegree), sy = std::sin(yaw * kDegree);
  v = {v.x, cr * v.y - sr * v.z, sr * v.y + cr * v.z};
  v = {cp * v.x + sp * v.z, v.y, -sp * v.x + cp * v.z};
  return {cy * v.x - sy * v.y, sy * v.x + cy * v.y, v.z};
}

Vec3 in_world(Vec3 mount_axes) {
  return turned_by({4, -6, 70}, turned_by({3, 20, -8}, mount_axes));
}

// 8 bits of sRGB, before they are rounded.
double coded(double light) {
  const double linear = std::clamp(light, 0.0, 1.0);
  return 255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055);
}

double light_of(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

}  // namespace

// Protects mounts and intrinsics: the middle of a sphere's mask, by matrices, to 0.1 pixel. The
// sphere is so far away that the middle of its image is that of its center to 0.01 pixel.
TEST_CASE("a sphere is where mount and intrinsics say") {
  const Vec3 body = {2, 3, -5};
  const Vec3 eye = body + turned_by({4, -6, 70}, {0.2, -0.3, 0.1});
  // 0.3 to the right and 0.2 up at a distance of 1 along the axis of view.
  const Vec3 center = eye + 6 * in_world({1, -0.3, 0.2});
  const Shot shot(
      scene(fmt::format("  - {{name: ball, material: m, shape: {{sphere: {{radius_m: 0.35}}}}, "
                        "pose: {{position_m: [{}, {}, {}]}}}}\n",
                        center.x, center.y, center.z)));
  double rows = 0, columns = 0;
  int count = 0;
  for (int row = 0; row < 121; ++row) {
    for (int column = 0; column < 161; ++column) {
      if (shot.view.instance[shot.at(row, column)] != 1) continue;
      rows += row;
      columns += column;
      ++count;
    }
  }
  REQUIRE(count > 50);
  const double x = 0.3, y = -0.2, r2 = x * x + y * y, s = 1 - 0.2 * r2 + 0.05 * r2 * r2;
  const double u = 80 + 110 * (s * x + 0.002 * x * y - 0.002 * (r2 + 2 * x * x));
  const double v = 60 + 112 * (s * y + 0.001 * (r2 + 2 * y * y) - 0.004 * x * y);
  CHECK(columns / count == Approx(u).margin(0.1));
  CHECK(rows / count == Approx(v).margin(0.1));
}

// Protects depth and normals: a plane and a sphere in closed form, in every pixel.
TEST_CASE("depth and normals of a plane and a sphere") {
  const Shot shot(
      scene("  - {name: bed, class: seabed, material: m, shape: {plane: {}}, "
            "pose: {position_m: [0, 0, -8]}}\n"
            "  - {name: ball, material: m, shape: {sphere: {radius_m: 0.8}}, "
            "pose: {position_m: [3.6, 6.5, -6.6]}}\n"));
  const Vec3 up = rotate(conjugate(shot.pose.rotation), {0, 0, 1});
  const Vec3 foot = shot.seen({0, 0, -8}), center = shot.seen({3.6, 6.5, -6.6});
  int of_plane = 0, of_ball = 0;
  for (int row = 0; row < 121; ++row) {
    for (int column = 0; column < 161; ++column) {
      const std::size_t i = shot.at(row, column);
      const Vec3 ray = pixel_direction(shot.camera.optics, column, row);
      double depth = dot(up, foot) / dot(up, ray);
      Vec3 normal = up;
      int instance = 1;
      if (!(depth > 0)) depth = 1e9;
      const double b = dot(ray, center), c = dot(center, center) - 0.64,
                   q = b * b - dot(ray, ray) * c;
      if (q > 0 && (b - std::sqrt(q)) / dot(ray, ray) < depth) {
        depth = (b - std::sqrt(q)) / dot(ray, ray);
        normal = (1 / 0.8) * (depth * ray - center);
        instance = 2;
      }
      if (depth * length(ray) > 99.9) continue;
      if (std::abs(q) < 1e-3) continue;  // the outline
      REQUIRE(shot.view.instance[i] == instance);
      REQUIRE(shot.view.semantic[i] == instance);
      REQUIRE(std::abs(shot.view.depth_m[i] - depth) < 1e-5 * depth);
      REQUIRE(std::abs(shot.view.normal_x[i] - normal.x) < 2e-4);
      REQUIRE(std::abs(shot.view.normal_y[i] - normal.y) < 2e-4);
      REQUIRE(std::abs(shot.view.normal_z[i] - normal.z) < 2e-4);
      (instance == 1 ? of_plane : of_ball)++;
    }
  }
  CHECK(of_plane > 5000);
  CHECK(of_ball > 200);
}

// Protects flow: a moving camera over a moving box. Each pixel's point, carried by hand, projects
// to where the flow leads.
TEST_CASE("flow is the projected motion") {
  const std::string moving =
      "trajectory: {pings: 3, ping_rate_hz: 2, poses: [{time_s: 0, position_m: [2, 3, -5], "
      "rotation_deg: [4, -6, 70]}, "
      "{time_s: 1, position_m: [2.4, 3.3, -5.2], rotation_deg: [2, -4, 76]}]}\n";
  const std::string objects =
      "  - {name: bed, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -8]}}\n"
      "  - {name: box, material: m, shape: {box: {size_m: [2, 2, 2]}}, trajectory: {poses: "
      "[{time_s: 0, position_m: [3.6, 6.5, -6.6]}, "
      "{time_s: 1, position_m: [3.2, 6.9, -6.5], rotation_deg: [0, 0, 20]}]}}\n";
  const Shot shot(scene(objects, "", moving));
  const Session& session = shot.run.session();
  const Pose then = camera_pose(session, shot.camera, 1);
  const auto now_objects = object_poses(session, 0), then_objects = object_poses(session, 1);
  int known = 0;
  double most_px = 0;
  for (int row = 0; row < 121; ++row) {
    for (int column = 0; column < 161; ++column) {
      const std::size_t i = shot.at(row, column);
      const int instance = shot.view.instance[i];
      if (instance == 0) {
        REQUIRE(std::isnan(shot.view.flow_x_px[i]));
        continue;
      }
      const Vec3 point =
          transform_point(shot.pose, double(shot.view.depth_m[i]) *
                                         pixel_direction(shot.camera.optics, column, row));
      const Pose& was = now_objects[instance - 1];
      const Vec3 moved =
          transform_point(then_objects[instance - 1], inverse_transform_point(was, point));
      const Vec3 p = inverse_transform_point(then, moved);
      const ImagePoint d = distorted(shot.camera.optics, {p.x / p.z, p.y / p.z});
      if (std::isnan(shot.view.flow_x_px[i])) continue;
      REQUIRE(std::abs(80 + 110 * d.x - column - double(shot.view.flow_x_px[i])) < 5e-4);
      REQUIRE(std::abs(60 + 112 * d.y - row - double(shot.view.flow_y_px[i])) < 5e-4);
      most_px = std::max(most_px, std::abs(double(shot.view.flow_x_px[i])));
      ++known;
    }
  }
  CHECK(known > 5000);
  CHECK(most_px > 5);
  // The last ping has none.
  const CameraView last = *shot.run.ping(2).camera;
  CHECK(std::all_of(last.flow_x_px.begin(), last.flow_x_px.end(),
                    [](float value) { return std::isnan(value); }));
}

// Protects colors of pixels: those of the formula for what the pixel shows, and no others with more
// rays of a pixel, where all of them show nearly the same.
TEST_CASE("colors of a seabed are those of the model") {
  const std::string bed =
      "  - {name: bed, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -8]}}\n";
  const std::string water =
      "  surface_z_m: 0\n  light: {daylight: 2, lamp: 1.5}\n  water: {jerlov: IB}\n";
  const Shot shot(scene(bed, water));
  const Shot fine(scene(bed, water + "  samples: 3\n"));
  const Rgb attenuation = {0.245, 0.054, 0.033};
  const double eye_m = -shot.pose.position_m.z;
  int seen = 0;
  for (int row = 0; row < 121; ++row) {
    for (int column = 0; column < 161; ++column) {
      const std::size_t i = shot.at(row, column);
      if (shot.view.instance[i] != 1) continue;
      const Vec3 ray = pixel_direction(shot.camera.optics, column, row);
      const double r = double(shot.view.depth_m[i]) * length(ray), cosine = (8 - eye_m) / r;
      if (r > 20) continue;
      const Rgb color = {0.8, 0.5, 0.2};
      for (std::size_t c = 0; c < 3; ++c) {
        const double k = attenuation[c], through = std::exp(-k * r);
        const double lit = color[c] * (2 * std::exp(-k * 8) + 1.5 * cosine / (r * r) * through);
        const double veil = 0.2 * 0.033 / k * (2 * std::exp(-k * eye_m) + 1.5);
        const double expected = coded(lit * through + veil * (1 - through));
        REQUIRE(std::abs(expected - shot.view.color[3 * i + c]) < 0.51);
        REQUIRE(std::abs(shot.view.color[3 * i + c] - fine.view.color[3 * i + c]) <= 2);
      }
      ++seen;
    }
  }
  CHECK(seen > 5000);
}

// Protects colors of vertices: those of the model for the corners' mean, weighted by the areas that
// the point cuts from the triangle, in clear water under daylight and lamp.
TEST_CASE("colors of a triangle are those of its corners") {
  const TemporaryFolder folder;
  const std::array<std::array<double, 3>, 3> codes = {
      {{0.9, 0.1, 0.3}, {0.2, 0.8, 0.4}, {0, 0.5, 1}}};
  const std::array<Vec3, 3> corners = {{{-2, -2.5, 0.3}, {2.5, -2, 0}, {0.2, 3, -0.4}}};
  std::string obj;
  for (int k = 0; k < 3; ++k) {
    obj += fmt::format("v {} {} {} {} {} {}\n", corners[k].x, corners[k].y, corners[k].z,
                       codes[k][0], codes[k][1], codes[k][2]);
  }
  const auto file = folder.write("a.obj", obj + "f 1 2 3\n");
  const Shot shot(
      scene(fmt::format("  - {{name: sheet, material: m, shape: {{mesh: {{file: {}}}}}, "
                        "pose: {{position_m: [3.4, 6, -7]}}}}\n",
                        file.string()),
            "  light: {daylight: 0.8, lamp: 0.6}\n"));
  const Vec3 across = cross(corners[1] - corners[0], corners[2] - corners[0]),
             normal = normalized(across);
  const std::vector<Vec3> rays = camera_rays(shot.camera.optics);
  std::vector<Hit> hits(rays.size());
  std::vector<VertexColor> painted(rays.size());
  Tracer(shot.run.session().world).first_hits(shot.pose, rays, 100, hits, painted);
  int seen = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    REQUIRE(painted[i].has_value() == (shot.view.instance[i] == 1));
    if (!painted[i]) continue;
    const Vec3 direction = rotate(shot.pose.rotation, normalized(rays[i]));
    const Vec3 from = shot.pose.position_m - Vec3{3.4, 6, -7};
    const double r = dot(corners[0] - from, normal) / dot(direction, normal);
    const Vec3 point = from + r * direction;
    for (std::size_t c = 0; c < 3; ++c) {
      double color = 0;
      for (int k = 0; k < 3; ++k) {
        const Vec3 a = corners[(k + 1) % 3], b = corners[(k + 2) % 3];
        color +=
            dot(cross(a - point, b - point), across) / dot(across, across) * light_of(codes[k][c]);
      }
      REQUIRE(std::abs((*painted[i])[c] - color) < 1e-5);
      const double lamp = 0.6 * std::abs(dot(normal, direction)) / (r * r);
      const double light = color * (0.8 * (1 + normal.z) / 2 + lamp);
      REQUIRE(std::abs(coded(light) - shot.view.color[3 * i + c]) < 0.51);
    }
    ++seen;
  }
  CHECK(seen > 2000);
}

// Protects the rule of colors: those of vertices replace the material's and its factors; what has
// grown on them hides them.
TEST_CASE("vertex colors replace the color of the material") {
  const TemporaryFolder folder;
  const auto image = [&](const std::string& color, const std::string& mesh,
                         const std::string& material) {
    std::string obj;
    for (const char* corner : {"-2 -2 0", "2 -2 0", "2 2 0", "-2 2 0"}) {
      obj += fmt::format("v {} {}\n", corner, color);
    }
    const auto file = folder.write("quad.obj", obj + "f 1 2 3 4\n");
    std::string text =
        scene(fmt::format("  - {{name: quad, material: quad, shape: {{mesh: {{file: {}{}}}}}, "
                          "pose: {{position_m: [3.4, 6, -7]}}}}\n"
                          "  - {{name: bed, material: m, shape: {{plane: {{}}}}, "
                          "pose: {{position_m: [0, 0, -8]}}}}\n",
                          file.string(), mesh),
              "  samples: 2\n");
    text.insert(text.find("{m: ") + 1, "quad: {reflectivity: 1e-3, color: " + material + "}, ");
    const Shot shot(text);
    CHECK(std::ranges::count(shot.view.instance, 1) > 1000);
    return shot.view.color;
  };
  const auto plain =
      fmt::format("[{:.17g}, {:.17g}, {:.17g}]", light_of(0.71), light_of(0.4), light_of(0.83));
  const std::string painted = "0.71 0.4 0.83", red = "[1, 0, 0]",
                    grown = ", growth: {material: m, cover: 0.4, correlation_m: 0.5}";
  const std::string uneven = ", texture: {model: gamma, shape: 2, correlation_m: 0.3}";
  const auto differing = [](const auto& a, const auto& b) {
    int count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
    return count;
  };
  const auto expected = image("", "", plain), patchy = image("", "", plain + grown);
  CHECK(differing(image("", "", red), expected) > 1000);
  CHECK(differing(patchy, expected) > 1000);
  CHECK(differing(image(painted, "", red), expected) == 0);
  CHECK(differing(image(painted, ", reflectivity: vertex_color", red + uneven), expected) == 0);
  CHECK(differing(image(painted, "", red + grown), patchy) == 0);
}

// Protects memory of scenarios without a camera, and a sonar from colors that are not its own: the
// world of a rig's sonar has them, and the sonar hears the same.
TEST_CASE("vertex colors are read for a camera, and change no echo") {
  const TemporaryFolder folder;
  const auto file = folder.write("bent.obj",
                                 "v -2 -2 0 1 0 0\nv 2 -2 0 0 1 0\nv 2 2 0.5 0 0 1\n"
                                 "v -2 2 0 1 1 0\nv 2 2 0.5 0 0 0\nf 1 2 3\nf 1 5 4\n");
  const std::string text = fmt::format(
      "  - {{name: bent, material: m, shape: {{mesh: {{file: {}, normals: smooth}}}}, "
      "pose: {{position_m: [3, 7, -5.3], rotation_deg: [0, 80, 70]}}}}\n",
      file.string());
  std::string with = scene(text);
  with.replace(with.find("timeseries: none"), 16, "timeseries: npy");
  const std::size_t begin = with.find("camera:"), end = with.find("materials:");
  std::string without = with.substr(0, begin) + with.substr(end);
  without.replace(without.find(", camera: {flow: true}"), 22, "");
  const SceneRun seen = SceneRun::of_text(with), heard = SceneRun::of_text(without);
  const auto colors = [](const SceneRun& run) {
    return std::get<MeshShape>(run.session().world.objects[0].shape).mesh->colors.size();
  };
  CHECK(std::pair{colors(seen), colors(heard)} == std::pair{std::size_t{6}, std::size_t{0}});
  const Series series = seen.ping(0).series;
  CHECK(std::abs(*std::ranges::max_element(series, {}, [](auto p) { return std::abs(p); })) > 0.1F);
  CHECK((series == heard.ping(0).series));
}

// Protects equal bytes on machines with more threads.
TEST_CASE("images of a camera do not depend on threads") {
  const Shot shot(
      scene("  - {name: bed, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -8]}}\n"));
  const CameraView other = *shot.run.ping(0, 1).camera, more = *shot.run.ping(0, 3).camera;
  for (const CameraPlane& plane : kCameraPlanes) {
    INFO(plane.name);
    with_plane(other, plane, [&](const auto& values) {
      with_plane(more, plane, [&](const auto& others) {
        if constexpr (std::is_same_v<decltype(values), decltype(others)>) {
          const auto bytes = values.size() * sizeof values[0];
          REQUIRE(values.size() == others.size());
          CHECK(std::memcmp(values.data(), others.data(), bytes) == 0);
        }
      });
    });
  }
}

// Protects what users see at a bound of the camera's range.
TEST_CASE("surfaces beyond the camera's range are not seen") {
  const Shot shot(
      scene("  - {name: bed, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -8]}}\n",
            "  range_max_m: 5\n"));
  for (int row = 0; row < 121; ++row) {
    for (int column = 0; column < 161; ++column) {
      const std::size_t i = shot.at(row, column);
      if (shot.view.instance[i] == 0) {
        CHECK(std::isnan(shot.view.depth_m[i]));
      } else {
        const double slant = length(pixel_direction(shot.camera.optics, column, row));
        CHECK(double(shot.view.depth_m[i]) * slant <= 5.00001);
      }
    }
  }
}
