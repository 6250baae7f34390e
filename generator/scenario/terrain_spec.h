// Terrain as a scenario describes it: heights over a regular grid, from a file or made up.
#pragma once

#include <array>
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

// Whole cells along a side of a procedural one, one at least.
int cells_along(double size_m, double cell_m);

}  // namespace ensonify
