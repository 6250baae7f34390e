// Boxes and run-length masks of the instances in an image, in COCO's conventions, and how they
// differ from the ground around them.
//
//   ImageRuns  instance_runs   the pixels of an image by column
//   annotations    one entry for each instance that has a pixel, by id
//   add_amodal     amodal masks and occlusion
//   rle_counts     COCO's compressed run lengths
//   contrasts_db   the expected level of an instance relative to the ground
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/ping.h"
#include "labels/shadow.h"

namespace ensonify {

// Pixels of one value other than 0 below each other.
struct ImageRun {
  std::uint32_t value = 0;
  int row = 0, length = 0;
};

struct ImageRuns {
  int rows = 0, columns = 0;
  std::vector<ImageRun> runs;        // by column, from the top
  std::vector<std::uint32_t> begin;  // [columns + 1]: the first run of each column

  std::span<const ImageRun> of_column(int column) const {
    return std::span(runs).subspan(begin[column], begin[column + 1] - begin[column]);
  }
};

ImageRuns instance_runs(const LabelledImage& image);

// `image`: instance_runs.
std::vector<Annotation> annotations(const ImageRuns& image);

// Adds amodal masks and occlusion (`occlusion` by instance id) to the annotations of the same
// image. Returns the annotations of the instances without a pixel of their own, by id.
std::vector<Annotation> add_amodal(const InstanceSets& amodal, std::span<const double> occlusion,
                                   std::vector<Annotation>& annotations);

// The text that COCO's tools use for run lengths (zeros first, column-major). From the fourth count
// on, each count is reduced by the one two places before it. Each number is written in 5-bit
// groups, the low group first; the sixth bit marks that more groups follow, and 48 is added.
std::string rle_counts(const std::vector<std::int64_t>& counts);

// For each of `annotations` of the polar image with these runs: 10 log10 of the mean expected power
// (`clean_power_pa2`, [beams x samples]) of the instance's pixels divided by that of the ground's
// pixels in its box. The box is enlarged on every side by half its width or height, at least by
// kContrastMargin_px. The ground of an instance consists of all other instances that are more than
// kGroundSize times as large. `size_m` is by instance id, and infinite for instances that are
// always ground. NaN if the enlarged box contains no ground, or if either mean is 0.
std::vector<double> contrasts_db(const ImageRuns& polar, std::span<const float> clean_power_pa2,
                                 std::span<const Annotation> annotations,
                                 std::span<const double> size_m);

inline constexpr int kContrastMargin_px = 8;
inline constexpr double kGroundSize = 10;

}  // namespace ensonify
