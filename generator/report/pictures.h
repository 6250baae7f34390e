// Images of the shown pings, and statistics of data sets with output.statistics, as chunks of the
// page. Private to report/.
//
//   Chunks  the binary pieces of a page; equal pieces are stored only once
//   CodedPing  PictureBook  encode_pictures         at most as many bytes as the page may have
//   CodedArray  CodedStatistics  encode_statistics  contrast and mean level of each listed sequence
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "report/look.h"

namespace ensonify {

class Chunks {
 public:
  Chunks() = default;
  Chunks(const Chunks&) = delete;
  Chunks& operator=(const Chunks&) = delete;

  // The number of the chunk.
  std::size_t add(std::string bytes) {
    const auto known = numbers_.find(bytes);
    if (known != numbers_.end()) return known->second;
    chunks_.push_back(std::move(bytes));
    numbers_.emplace(chunks_.back(), chunks_.size() - 1);
    return chunks_.size() - 1;
  }
  std::size_t size() const { return chunks_.size(); }
  const std::string& operator[](std::size_t number) const { return chunks_[number]; }

 private:
  std::deque<std::string> chunks_;  // keys of numbers_ refer to these texts, which never move
  std::unordered_map<std::string_view, std::size_t> numbers_;
};

struct CodedPing {
  // Numbers of chunks.
  std::optional<std::size_t> level, clean, elevation, labels, shadow, multipath;
  std::size_t beam = 0;  // the beam whose levels are exact
  std::optional<std::size_t> beam_level, beam_clean;
};

struct PictureBook {
  std::vector<CodedPing> pings;  // as Survey::shown
  int quality = 0;               // of lossy images
  int elevation_step = 1;        // every n-th row and column of elevations is kept
};

// Encodes images with the best quality that fits into `budget` bytes of base64.
Result<PictureBook> encode_pictures(const PictureJob& job, const PictureScale& scale,
                                    std::uint64_t budget, Chunks& chunks);

struct CodedArray {
  std::string name, unit, what;
  double min = 0, max = 1;  // of codes 1 and 255
  std::size_t chunk = 0;
};

struct CodedStatistics {
  std::size_t sequence = 0;  // place in Survey::sequences
  std::uint64_t realisations = 0;
  std::vector<CodedArray> arrays;
};

Result<std::vector<CodedStatistics>> encode_statistics(const PictureJob& job, Chunks& chunks);

}  // namespace ensonify
