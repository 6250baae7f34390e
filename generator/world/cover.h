// Stones and patches of other sediment on terrain; stones are part of its heights. Both depend only
// on a key and the position in the terrain's frame, so a change of cell or size does not move them.
//
//   standard_normal_quantile
//   patch_weights  lay_patches     other sediment
//   Stone  stones_within           a Poisson process
//   stone_height_m  lay_stones     the upper side of an ellipsoid
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "scenario/terrain_spec.h"
#include "world/terrain.h"

namespace ensonify {

// The value below which a standard normal variable lies with the given probability. Returns -10 for
// 0 and 10 for 1.
double standard_normal_quantile(double probability);

// One weight per grid point: 1 in a patch, 0 outside, with a smooth transition that is 1/2 in the
// middle of the border. A normal random field g of variance 1 is a moving average of keyed normal
// numbers half a correlation length apart; the middle of the border is g = t = quantile(1 - share).
// The distance to it is approximated by (g - t) / |grad g|, where the gradient is at least a
// seventh of its rms.
std::vector<float> patch_weights(const PatchSpec& patch, std::uint64_t key, std::size_t number,
                                 const HeightGrid& grid);

// `key` is that of the terrain. `factors` multiply the material's reflectivity, one per point; an
// empty list stands for 1 everywhere, and stays empty if no patch changes the reflectivity.
void lay_patches(const std::vector<PatchSpec>& patches, std::uint64_t key, const HeightGrid& grid,
                 std::vector<float>& factors);

// An ellipsoid that is upright in the terrain's frame, with `buried_fraction` of its height below
// the bed.
struct Stone {
  double x_m = 0, y_m = 0;
  double diameter_m = 0;  // along `yaw_rad`; across it, aspect times this
  double aspect = 1;
  double yaw_rad = 0;
  double height_m = 0;
  double buried_fraction = 0;
};

// Stones whose outlines reach into the rectangle with these half sides around the origin.
std::vector<Stone> stones_within(const StoneSpec& stones, std::uint64_t key, std::size_t number,
                                 std::array<double, 2> half_m);

// The height of the stone's surface above the bed; none outside the stone.
std::optional<double> stone_height_m(const Stone& stone, double x_m, double y_m);

// Each stone stands at the height of the bed under its center. At each point the highest surface is
// kept, with its factor. A stone over a hole is omitted.
void lay_stones(const std::vector<StoneSpec>& populations, std::uint64_t key, HeightGrid& grid,
                std::vector<float>& factors);

}  // namespace ensonify
