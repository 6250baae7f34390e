// Statistics of data sets with output.statistics, as chunks of the page. Private to report/.
//
//   encode_statistics   contrast and mean level of each listed sequence that has them
#pragma once

#include <string>
#include <vector>

#include "report/chunks.h"
#include "report/pictures.h"

namespace ensonify {

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
