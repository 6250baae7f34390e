// Terrain as a scenario describes it: heights over a regular grid, from a file or synthetic, and
// what lies on it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ensonify {

// Isotropic, normally distributed heights with the spectrum (K^2 + K0^2)^(-exponent/2), K0 = 2 pi /
// outer scale.
struct RoughnessSpec {
  double rms_m = 0;
  double exponent = 3;
  double outer_scale_m = 10;
  friend bool operator==(const RoughnessSpec&, const RoughnessSpec&) = default;
};

// Trochoids with sharp crests and wide troughs. The direction is that of the wave vector, from x to
// y.
struct RippleSpec {
  double height_m = 0;  // trough to crest
  double wavelength_m = 0;
  double direction_deg = 0;
  friend bool operator==(const RippleSpec&, const RippleSpec&) = default;
};

// Ellipsoids in the seabed. Ranges are [least, most]; each stone has its own value, uniform within
// the range, except for the diameter (the longer axis seen from above): the share of stones with a
// diameter above D is proportional to D^-exponent - largest^-exponent.
struct StoneSpec {
  double density_per_m2 = 0;
  std::array<double, 2> diameter_m{};
  double exponent = 3;
  std::array<double, 2> aspect{0.6, 1};             // shorter axis over the longer one, from above
  std::array<double, 2> height_ratio{0.4, 0.8};     // height of the ellipsoid over its diameter
  std::array<double, 2> buried_fraction{0.3, 0.7};  // of that height
  double reflectivity_db = 0;                       // relative to the bed's material
  friend bool operator==(const StoneSpec&, const StoneSpec&) = default;
};

// Other sediment covers the area where a normal random field with the covariance exp(-r^2 / (2
// correlation^2)) is in its upper `share`.
struct PatchSpec {
  double share = 0;
  double correlation_m = 0;
  double border_m = 0.2;
  double reflectivity_db = 0;  // relative to the bed's material
  double relief_factor = 1;    // of a synthetic seabed: on ripples and short waves
  friend bool operator==(const PatchSpec&, const PatchSpec&) = default;
};

// Either a file or a size; the cell is required except for .asc, which states its own.
struct HeightfieldSpec {
  std::filesystem::path file;  // NPY, PNG or ESRI ASCII; empty: synthetic
  double height_scale = 1;     // for a file: height = scale * value + offset
  double height_offset_m = 0;

  std::array<double, 2> size_m{};  // for a synthetic one: along x, along y
  std::optional<RoughnessSpec> roughness;
  std::vector<RippleSpec> ripples;

  double cell_m = 0;
  bool smooth_normals = false;
  std::filesystem::path reflectivity_map;  // NPY or PNG; empty: none

  std::vector<PatchSpec> patches;  // a later one lies over earlier ones
  std::vector<StoneSpec> stones;   // above all of them
  friend bool operator==(const HeightfieldSpec&, const HeightfieldSpec&) = default;
};

// Whether sequences differ in the terrain.
bool is_random(const HeightfieldSpec& field);

// Vertices of a synthetic seabed along x and y: its sides in whole cells (at least one), plus one.
std::array<int, 2> vertices_along(const HeightfieldSpec& field);

// Period of its roughness along x and y in cells: powers of two that cover the terrain and, as far
// as the longer side of the terrain does, the outer scale, without which the long waves are wrong.
std::array<std::int64_t, 2> roughness_period(const HeightfieldSpec& field);

// A key of the stones or patches and what is wrong with its value for this cell size.
struct CoverFault {
  std::string key, what;
};

// Diameters or correlation lengths below two cells; more than 1e6 stones on an area of `size_m`;
// stones whose outlines would cover the area more than once.
std::optional<CoverFault> stone_fault(const StoneSpec& stones, double cell_m,
                                      std::array<double, 2> size_m);
std::optional<CoverFault> patch_fault(const PatchSpec& patch, double cell_m);

}  // namespace ensonify
