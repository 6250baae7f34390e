// 8-bit Cartesian images of polar levels, as a sonar viewer makes them: near ranges show no grid of
// dots and far ranges no blocks.
//
//   Footprints  footprints            where each Cartesian pixel lies in the polar image
//   cartesian_gains                   the time-varied gain at each pixel
//   displayed_cartesian               the gray levels
//
// The footprint of a pixel with edge e (m) at range r is e / (r spacing) beams wide and e / step
// samples long. It is divided into m x n parts, both the widths rounded up; the pixel shows the
// mean of the intensities 10^(level / 10) at the centers of the parts, each interpolated
// bilinearly between beams and samples. The middle of a footprint, and the parts, that lie beyond
// the first or last beam or sample are taken to lie on it, and no footprint is wider than the fan
// or nearer than half a sample. Where no footprint is larger than a cell this is plain bilinear interpolation; where
// beams are denser than pixels it is the mean over all of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/ping.h"
#include "labels/display.h"

namespace ensonify {

// Of the pixels in the fan, in the order of their numbers. A pixel lies between the polar pixels
// `from` and the next in beam and sample, by fractions in units of 2^-15.
struct Footprints {
  int rows = 0, columns = 0;        // of the Cartesian image
  int beams = 0, samples = 0;       // of the polar one
  double samples_per_px = 0;        // length of all footprints
  double beams_samples_per_px = 0;  // width in beams times the distance from the sonar in samples
  std::vector<std::int32_t> to;     // row * columns + column
  std::vector<std::int32_t> from;   // sample * beams + beam
  std::vector<std::uint16_t> beam_fraction, sample_fraction;
  std::vector<std::uint32_t> large;  // those that are divided, ascending: indices of `to`
};

// `map`: cartesian_map (labels/cartesian.h), whose pixels that show something are those in the fan.
Footprints footprints(const CartesianGrid& grid, const Sonar& sonar, const Water& water,
                      const Record& record, std::span<const std::int32_t> map);

// 10^(tvg / 10) at the range of each pixel of `to`, or at that of sample 1 before it, divided by
// the last sample's; empty without time-varied gain.
std::vector<float> cartesian_gains(const DisplayTable& table, const Footprints& footprints);

// Black outside the fan and where there is no energy. `gains`: cartesian_gains; `further_gain_db`:
// that of the polar image (DisplayedImage).
GreyImage displayed_cartesian(const DisplayTable& table, const Footprints& footprints,
                              std::span<const float> gains, double further_gain_db,
                              std::span<const float> level_db);

}  // namespace ensonify
