// Our own part of reading meshes: whether a file is all there and what the reader is given instead,
// told by its first byte which format, what the importer hands over, and faces of many corners.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "fuzz_file.h"
#include "world/import/import.h"
#include "world/import/polygon.h"
#include "world/import/vertex_data.h"
#include "world/import/wire.h"

using namespace ensonify;

namespace {

void read_wire(std::string_view bytes, bool density) {
  const WireInput in{[&bytes](void* to, std::size_t wanted) {
                       if (wanted > bytes.size()) return false;
                       if (wanted > 0) std::memcpy(to, bytes.data(), wanted);
                       bytes.remove_prefix(wanted);
                       return true;
                     },
                     std::uint64_t{1} << 28};
  if (density) {
    const auto grid = read_density(in);
    if (!grid) return;
    density_at(*grid, {1, 2, 3});
    test::accepted();
    return;
  }
  auto mesh = read_mesh(in);
  if (!mesh) return;
  drop_faces_without_area(*mesh);
  if (!check_extent(*mesh, "a.obj")) return;
  for (const auto& [a, b, c] : mesh->triangles) {
    const Vec3 p = to_vec3(mesh->vertices[a]);
    for (const std::uint32_t other : {b, c}) {
      test::promise(length(to_vec3(mesh->vertices[other]) - p) <= 2e6);
    }
  }
  test::accepted();
}

Vec3 area_of(const std::vector<std::array<float, 3>>& corners,
             const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  Vec3 sum;
  for (const auto& [a, b, c] : triangles) {
    const Vec3 p = to_vec3(corners[a]);
    sum = sum + cross(to_vec3(corners[b]) - p, to_vec3(corners[c]) - p);
  }
  return 0.5 * sum;
}

// Corners on a small grid touch and cross each other often. The last byte of each is its height.
void divide(std::string_view bytes) {
  std::vector<std::array<float, 3>> corners;
  const std::size_t most = std::min<std::size_t>(bytes.size() / 3, 200);
  for (std::size_t i = 0; i < most; ++i) {
    const auto at = [&](std::size_t k) { return static_cast<signed char>(bytes[3 * i + k]); };
    corners.push_back(
        {static_cast<float>(at(0)), static_cast<float>(at(1)), 1e-6f * static_cast<float>(at(2))});
  }
  if (corners.size() < 3) return;
  const DividedFace face = divide_face(corners);
  test::promise(face.triangles.size() <= corners.size() - 2);
  std::vector<std::array<std::uint32_t, 3>> fan;
  for (std::uint32_t i = 2; i < corners.size(); ++i) fan.push_back({0, i - 1, i});
  for (const auto& triangle : face.triangles) {
    test::promise(std::max({triangle[0], triangle[1], triangle[2]}) < corners.size());
  }
  if (!face.simple) return;
  // Those of a simple face have its area, and all one winding, but for the errors of position that
  // do not count.
  double around = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    around += length(to_vec3(corners[i]) - to_vec3(corners[(i + 1) % corners.size()]));
  }
  const double error = 1e-5 * 255 * around, wanted = area_of(corners, fan).z;
  test::promise(std::abs(area_of(corners, face.triangles).z - wanted) <= error);
  for (const auto& triangle : face.triangles) {
    test::promise(area_of(corners, {triangle}).z * (wanted < 0 ? -1 : 1) >= -error);
  }
  test::accepted();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes = test::text_of(data + 1, size - 1);
  constexpr std::array kNames = {"a.ply", "a.stl", "a.gltf"};
  const unsigned choice = data[0] % 7;
  if (choice == 3 || choice == 4) {
    read_wire(bytes, choice == 3);
  } else if (choice == 6) {
    divide(bytes);
  } else if (const char* name = choice == 5 ? "a.glb" : kNames[choice];
             const auto prepared = prepare_mesh_bytes(name, std::string(bytes), true)) {
    // What is changed once is right the second time.
    if (prepared->changed) {
      const auto again = prepare_mesh_bytes(name, *prepared->changed, false);
      test::promise(again.ok() && !again->changed);
    }
    if (check_obj_colors(name, bytes)) test::accepted();
  }
  return 0;
}
