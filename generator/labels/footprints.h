// Where the pixels of a Cartesian image lie in the polar image.
//
//   Footprints  footprints  footprint_taps   the part of the polar image that each pixel shows
//   sample_place             the range of a pixel
//   is_grid_of_fan           whether a grid from a file is plausible
//
// The footprint of a pixel with edge e (m) at range r is e / (r spacing) beams wide (the mean
// spacing where beams are not equally spaced) and e / step samples long, but no wider than the fan,
// and r is at least half a sample. It is divided into equal parts; their number in each direction is its size in cells, rounded up. The pixel shows the
// mean of the intensities 10^(level / 10) at the centers of the parts, each interpolated bilinearly
// between beams and samples. Centers beyond the first or last beam or sample are moved to it. If no
// footprint is larger than a cell, this is bilinear interpolation; where beams are denser than
// pixels, it is the mean over all of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/ping.h"

namespace ensonify {

// Places in the polar image are in units of 2^-kPlaceBits of a cell.
inline constexpr int kPlaceBits = 15;

// The pixels in the fan: first the narrow ones, whose footprints are at most one beam wide and
// whose parts are all within the record, then the wide ones. The mean of a pixel is the sum over
// beams and samples of 2^-15 times intensity times both weights, times `scale`. Sums over samples
// have `taps` terms from the first sample with a weight on: four partial sums of each fourth term,
// which are added in pairs. Places of parts are rounded to 2^-15 of a cell, and weights along
// samples are in these units.
struct Footprints {
  CartesianGrid grid;
  int beams = 0, samples = 0;  // of the polar image
  double samples_per_m = 0, first_sample = 0;
  double samples_per_px = 0;        // length of all footprints
  double beams_samples_per_px = 0;  // width in beams times range in samples
  int taps = 0;                     // a multiple of four
  std::size_t line = 0;             // intensities from one beam to the next
  float scale = 0;                  // 1 / (parts along samples)
  std::vector<std::int32_t> to;     // row * columns + column
  std::vector<std::uint32_t> from;  // beam * line + sample of the first weights
  // Narrow pixels: fractions of the next beam in units of 2^-15, and [narrow x taps].
  std::vector<std::uint16_t> beam_fraction, sample_weight;
  // Wide pixels: [wide x taps], and those of beams from beam_begin[i] to beam_begin[i + 1].
  std::vector<float> wide_weight, beam_weight;
  std::vector<std::uint32_t> beam_begin;
};

// Whether the grid is hardly larger than the fan. Otherwise footprints is not defined, and the work
// would exceed what the pixels of both images justify. The arguments may have any values, such as
// those of an untrusted file.
bool is_grid_of_fan(const CartesianGrid& grid, const Sonar& sonar, const Water& water,
                    const Record& record);

// The number of weights along samples of footprints of this length.
int footprint_taps(double samples_per_px, int samples);

// `map`: cartesian_map (labels/cartesian.h); its pixels from 0 are those in the fan.
Footprints footprints(const CartesianGrid& grid, const Sonar& sonar, const Water& water,
                      const Record& record, std::span<const std::int32_t> map);

// The sample that the middle of a pixel lies at, in units of 2^-kPlaceBits, rounded and within the
// record.
double sample_place(const Footprints& footprints, std::int32_t pixel);

}  // namespace ensonify
