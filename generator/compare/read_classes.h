// Which pixels of pings show objects, shadows and background. Private to compare/.
//
//   ClassSource              where masks and labels come from
//   PingPlace  read_classes  of some pings
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "compare/pings.h"
#include "core/error.h"
#include "core/parallel.h"
#include "dataset/read_dataset.h"

namespace ensonify {

struct ClassSource {
  bool wanted = false;
  // One 8-bit PNG [samples, beams] for each ping of the data set, in the order of their names: 0
  // background, 255 shadow, all other values objects. Empty: the labels of the data set, if it has
  // any.
  std::filesystem::path masks;
  // Of labels: names of the classes that are objects. Empty: things of finite size.
  std::vector<std::string> objects;
};

using PingPlace = std::pair<std::size_t, std::uint32_t>;  // index of the sequence, ping

// [pings][samples x beams] of PixelClass; empty if nothing says what the pixels show. Error
// (usage): another number of masks than pings, a mask of another kind or size, or no class of one
// of the names; (io): unreadable or damaged.
Result<std::vector<std::vector<std::uint8_t>>> read_classes(
    const ClassSource& source, const StoredDataset& dataset,
    const std::vector<StoredSequence>& sequences, const std::vector<PingPlace>& places,
    const Workers& workers);

}  // namespace ensonify
