// Boxes and run-length masks of the instances in an image, in COCO's conventions.
//
//   annotations   one entry for each instance that has a pixel, by id
//   add_amodal    amodal masks and occlusion
//   rle_counts    COCO's compressed run lengths
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/ping.h"
#include "labels/shadow.h"

namespace ensonify {

std::vector<Annotation> annotations(const LabelledImage& image);

// Adds amodal masks and occlusion (`occlusion` by instance id) to the annotations of the same
// image. Returns the annotations of the instances without a pixel of their own, by id.
std::vector<Annotation> add_amodal(const InstanceSets& amodal, std::span<const double> occlusion,
                                   std::vector<Annotation>& annotations);

// The text that COCO's tools use for run lengths (zeros first, column-major). From the fourth count
// on, each count is reduced by the one two places before it. Each number is written in 5-bit
// groups, the low group first; the sixth bit marks that more groups follow, and 48 is added.
std::string rle_counts(const std::vector<std::int64_t>& counts);

}  // namespace ensonify
