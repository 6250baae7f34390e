// Images of the shown pings, and statistics of data sets with output.statistics, as chunks of the
// page. Private to report/.
//
//   CodedPing  PictureBook  encode_pictures         at most as many bytes as the page may have
//   CodedArray  CodedStatistics  encode_statistics  contrast and mean level of each listed sequence
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "report/chunks.h"
#include "report/look.h"

namespace ensonify {

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
