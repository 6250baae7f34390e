// What the images of a sequence are made with, and how those of a ping follow.
//
//   SequenceDisplay  sequence_table  sequence_display
//   shown_polar  shown_cartesian   the images of a ping
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dataset/read_dataset.h"
#include "labels/cartesian_display.h"
#include "labels/display.h"
#include "render/part.h"

namespace ensonify {

// What the images of a sequence are made with.
struct SequenceDisplay {
  DisplayTable table;
  std::optional<SequencePart> part;      // unless it is the whole
  std::vector<std::int32_t> map;         // empty without Cartesian images; of the part
  std::optional<Footprints> footprints;  // unless the images are nearest neighbor
  std::vector<float> gains;
};

// The display at the ranges of the sequence's samples.
DisplayTable sequence_table(const Display& display, const StoredSequence& sequence);

// Errors: those of sequence_part, part_of_map and read_cartesian_map; (io) a damaged grid.
Result<SequenceDisplay> sequence_display(const StoredDataset& dataset,
                                         const StoredSequence& sequence, const Display& display,
                                         const ShownPart& shown, bool with_cartesian);

// `pixels`: level_db and, unless it is a recording, elevation_rad of the polar image; `blocks`:
// block_pixels of a part, else empty.
DisplayedImage shown_polar(const StoredSequence& sequence, const SequenceDisplay& shown,
                           const ImagePlanes& pixels, std::span<const std::uint32_t> blocks);

// `polar`: of shown_polar.
GreyImage shown_cartesian(const StoredSequence& sequence, const SequenceDisplay& shown,
                          const ImagePlanes& pixels, std::span<const std::uint32_t> blocks,
                          const DisplayedImage& polar);

}  // namespace ensonify
