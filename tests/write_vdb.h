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
};

void write_vdb(const std::filesystem::path& file, const std::vector<VdbGrid>& grids);

}  // namespace ensonify::test
