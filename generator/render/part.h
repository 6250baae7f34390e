// The pixels that a render shows of a sequence's images: a window in range, decimated.
//
//   SequencePart  sequence_part   which ones
//   part_of_table                 the display at the ranges of the rows
//   block_pixels                  the pixel that each polar pixel of the render shows
//   held                          its value all over its block, for bilinear Cartesian images
//   part_of_map  cut              the pixels of Cartesian images
//
// A block is ShownPart::samples x ShownPart::beams polar pixels, from the first sample of the
// window and from beam 0; the last blocks may be smaller.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/error.h"
#include "core/ping.h"
#include "dataset/read_dataset.h"
#include "dataset/render_manifest.h"
#include "labels/display.h"

namespace ensonify {

struct SequencePart {
  ShownPart shown;
  std::size_t beams = 0;              // of the data set's images
  std::size_t first = 0, end = 0;     // samples [first, end)
  std::size_t rows = 0, columns = 0;  // of the polar images of the render
  PartPixels polar, cartesian;        // cartesian: filled by part_of_map
};

// Sample n, at the range r = first_range_m + n range_step_m, is in the window if from <= r <= to.
// Error (usage): no sample is, or blocks are larger than the window or the fan.
Result<SequencePart> sequence_part(const ShownPart& shown, const StoredSequence& sequence);

// Row i has the gain of the middle sample of its blocks.
DisplayTable part_of_table(const DisplayTable& table, const SequencePart& part);

// [rows x columns], sample * beams + beam: the middle pixel of each block (of two, the nearer one
// and the one to starboard), or the one with the largest level (of equal ones, the first).
std::vector<std::uint32_t> block_pixels(const SequencePart& part, std::span<const float> level_db);

// The levels, but those in the window are those of block_pixels.
std::vector<float> held(const SequencePart& part, std::span<const std::uint32_t> pixels,
                        std::span<const float> level_db);

// Cuts a map of cartesian_map (labels/cartesian.h) to the smallest rectangle with all pixels that
// lie nearest to a sample of the window, the others become -1; the polar pixels are those of the
// render. Error (usage): no such pixel.
Result<std::vector<std::int32_t>> part_of_map(SequencePart& part, std::span<const std::int32_t> map,
                                              const StoredSequence& sequence);

// The same rectangle of an image; black where the cut map is -1.
GreyImage cut(const SequencePart& part, const GreyImage& image, std::span<const std::int32_t> map);

}  // namespace ensonify
