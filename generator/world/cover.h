// Stones and patches of other sediment on terrain; stones are part of its heights. Both are
// functions of a key and the position in the terrain's frame, so another cell or size does not move
// them.
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

// The value below which a standard normal variable lies with that probability; -10 and 10 for 0 and
// 1.
double standard_normal_quantile(double probability);

// One weight per grid point: 1 in a patch, 0 outside, smooth over the border, 1/2 on its middle. A
// normal random field g of variance 1 is a moving average of keyed normal numbers half a
// correlation length apart; the middle is g = t = quantile(1 - share), and the distance to it is
// taken as (g - t) / |grad g|, where the gradient counts for no less than a seventh of its rms.
std::vector<float> patch_weights(const PatchSpec& patch, std::uint64_t key, std::size_t number,
                                 const HeightGrid& grid);

// `key` is the terrain's, `number` the index in its list. `factors` on the material's reflectivity
// are one a point, or none for 1; they stay none where nothing makes them differ.
void lay_patches(const std::vector<PatchSpec>& patches, std::uint64_t key, const HeightGrid& grid,
                 std::vector<float>& factors);

// An ellipsoid upright in the terrain's frame, `buried_fraction` of its height below the bed.
struct Stone {
  double x_m = 0, y_m = 0;
  double diameter_m = 0;  // along `yaw_rad`; across it: aspect times as much
  double aspect = 1;
  double yaw_rad = 0;
  double height_m = 0;
  double buried_fraction = 0;
};

// Stones whose outlines reach into the rectangle with these half sides around the origin.
std::vector<Stone> stones_within(const StoneSpec& stones, std::uint64_t key, std::size_t number,
                                 std::array<double, 2> half_m);

// Height of its surface above the bed; none outside it.
std::optional<double> stone_height_m(const Stone& stone, double x_m, double y_m);

// Each stone stands at the height of the bed under its center, and the highest of all surfaces is
// kept, with its factor. A stone on a hole is omitted.
void lay_stones(const std::vector<StoneSpec>& populations, std::uint64_t key, HeightGrid& grid,
                std::vector<float>& factors);

}  // namespace ensonify
