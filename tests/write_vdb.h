// OpenVDB files for tests, without OpenVDB's headers in each of them.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace ensonify::test {

enum class VdbKind { fog, level_set, doubles, vectors };

struct VdbBox {
  std::array<int, 3> low{}, high{};  // both included
  float value = 1;
};

// Voxels of one size, voxel i with its middle at i * voxel_m + offset_m.
struct VdbGrid {
  std::string name = "density";
  double voxel_m = 0.1;
  std::array<double, 3> offset_m{};
  float background = 0;
  VdbKind kind = VdbKind::fog;
  bool frustum = false;
  std::vector<VdbBox> boxes;
  // In place of boxes: signed distances in metres, three voxels to either side, within +-extent
  // voxels; the background is theirs.
  std::function<double(double x_m, double y_m, double z_m)> distance_m = nullptr;
  int extent = 0;
  bool mirrored = false;  // x counts backwards
};

// A level set of a sphere about `offset_m`.
VdbGrid vdb_sphere(double radius_m, double voxel_m);

void write_vdb(const std::filesystem::path& file, const std::vector<VdbGrid>& grids);

}  // namespace ensonify::test
