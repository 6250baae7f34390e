// The 8-bit images that a display makes of a sequence.
//
//   SequenceDisplay  sequence_table  sequence_display   what they are made with
//   shown_polar  shown_cartesian   the images of a ping
//   mapped  flipped                seen through a map, or reversed
//   encode_image                   the bytes of a file
//   display_warning                whether the display fits the levels
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/display.h"
#include "core/error.h"
#include "core/ping.h"
#include "dataset/read_dataset.h"
#include "labels/cartesian_display.h"
#include "labels/display.h"
#include "render/part.h"

namespace ensonify {

// Reverses columns, rows or both.
GreyImage flipped(const GreyImage& image, Flip flip);

// The image seen through a sequence's map, sample * beams + beam or -1 for each of its pixels
// [rows x columns]; black outside the fan.
GreyImage mapped(const GreyImage& polar, std::span<const std::int32_t> map, int rows, int columns);

// A PNG file: gray or, with a color map, indices into its 256 colors, which are the gray levels.
// With a quality, a JPEG file, which is gray. Needs a color map that find_colour_map knows. Error:
// that of encode_png, or an image too large for JPEG.
Result<std::string> encode_image(const GreyImage& image, const Display& display,
                                 std::uint32_t jpeg_quality = 0);

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

inline constexpr double kMostWhite = 0.01, kMostBlack = 0.9;

// A warning if more than kMostWhite of the pixels are white, or more than kMostBlack of those with
// echoes are black (pixels without echoes always are); otherwise empty. `dataset`: the folder, as
// the user named it.
std::string display_warning(const Display& display, const DisplayCounts& counts,
                            const std::string& dataset);

}  // namespace ensonify
