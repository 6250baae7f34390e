// Boxes and run-length masks of the instances in a picture, in COCO's conventions.
//
//   annotations   one entry for each instance that has a pixel, by id
//   add_amodal    what of each is hidden
//   rle_counts    COCO's compressed run lengths
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/ping.h"
#include "labels/shadow.h"

namespace ensonify {

std::vector<Annotation> annotations(const LabelledImage& image);

// Puts amodal mask and occlusion (by instance id) into the annotations of the same picture, and
// gives those of the instances that have no pixel of their own, by id.
std::vector<Annotation> add_amodal(const InstanceSets& amodal, std::span<const double> occlusion,
                                   std::vector<Annotation>& annotations);

// The text that COCO's tools use for run lengths (zeros first, column-major): each count, from the
// fourth on less the one two before it, in 5-bit groups, low first, bit 6 for more, offset 48.
std::string rle_counts(const std::vector<std::int64_t>& counts);

}  // namespace ensonify
