// Terrain as a scenario describes it: heights over a regular grid, from a file or made up.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace ensonify {

// Isotropic, normal heights of the spectrum (K^2 + K0^2)^(-exponent/2), K0 = 2 pi / outer scale.
struct RoughnessSpec {
  double rms_m = 0;
  double exponent = 3;
  double outer_scale_m = 10;
  friend bool operator==(const RoughnessSpec&, const RoughnessSpec&) = default;
};

// Trochoids: sharp crests, wide troughs. The direction is that of the wave vector, from x to y.
struct RippleSpec {
  double height_m = 0;  // trough to crest
  double wavelength_m = 0;
  double direction_deg = 0;
  friend bool operator==(const RippleSpec&, const RippleSpec&) = default;
};

// Either a file or a size; the cell must be given but for .asc, which brings its own.
struct HeightfieldSpec {
  std::filesystem::path file;  // NPY, PNG or ESRI ASCII; empty: procedural
  double height_scale = 1;     // of a file: height = scale * value + offset
  double height_offset_m = 0;

  std::array<double, 2> size_m{};  // of a procedural one: along x, along y
  std::optional<RoughnessSpec> roughness;
  std::vector<RippleSpec> ripples;

  double cell_m = 0;
  bool smooth_normals = false;
  std::filesystem::path reflectivity_map;  // NPY or PNG; empty: none
  friend bool operator==(const HeightfieldSpec&, const HeightfieldSpec&) = default;
};

// Vertices of a procedural one along x and y: its sides in whole cells, one at least, and one more.
std::array<int, 2> vertices_along(const HeightfieldSpec& field);

// Period of its roughness along x and y, in cells: powers of two that hold the terrain and, as far
// as the terrain's longer side does, the outer scale, without which the long waves come out wrong.
std::array<std::int64_t, 2> roughness_period(const HeightfieldSpec& field);

}  // namespace ensonify
