// Images in Cartesian coordinates. They show the fan from above with the boresight up and port on
// the left, and take the nearest neighbor from the polar image.
//
//   cartesian_grid             the position of a pixel in meters
//   cartesian_map              the polar pixel that it shows
//   ResampledPlanes  resample  the image
#pragma once

#include <cstdint>
#include <vector>

#include "core/ping.h"

namespace ensonify {

struct InstanceSets;  // labels/shadow.h

// The smallest grid of `height_px` rows with square pixels that holds the whole fan.
CartesianGrid cartesian_grid(const Sonar& sonar, int height_px);

// For each Cartesian pixel, row-major, the index of the polar pixel (sample * beams + beam) whose
// beam cell contains its azimuth and whose sample is nearest to its range; -1 outside the fan and
// beyond the record.
std::vector<std::int32_t> cartesian_map(const CartesianGrid& grid, const Sonar& sonar,
                                        const Water& water, const Record& record);

// With `ids` the float planes of the image stay empty.
enum class ResampledPlanes { all, ids };

// Pixels outside the fan have kNoEnergyDb, NaN angles and instance 0. `sets`: those of the polar
// image, which become those of the Cartesian one.
LabelledImage resample(const LabelledImage& polar, const CartesianGrid& grid,
                       const std::vector<std::int32_t>& map,
                       ResampledPlanes planes = ResampledPlanes::all, InstanceSets* sets = nullptr);

// The same for an 8-bit image; black outside the fan.
GreyImage resample(const GreyImage& polar, const CartesianGrid& grid,
                   const std::vector<std::int32_t>& map);

}  // namespace ensonify
