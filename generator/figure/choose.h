// What is to be drawn: options held against the data set.
//
//   FigureJob  choose
//   is_animated  is_mask
#pragma once

#include <vector>

#include "dataset/read_pictures.h"
#include "figure/colour_map.h"
#include "figure/figure.h"

namespace ensonify {

enum class FigureFormat { png, svg, webp, mp4 };

struct FigureJob {
  FigureFormat format = FigureFormat::png;
  StoredDataset dataset;
  StoredSequence sequence;
  std::uint32_t first_ping = 0, last_ping = 0;  // [first, last)
  PictureChannels channels;                     // to be read
  const ColourMap* map = nullptr;               // null for masks
  std::vector<bool> chosen;                     // [id]: drawn; of all instances, and none
};

bool is_animated(FigureFormat format);
bool is_mask(FigureChannel channel);

// Error (usage): not a finished data set, or it has not got what was asked for; (io) it is damaged.
Result<FigureJob> choose(const FigureOptions& options);

}  // namespace ensonify
