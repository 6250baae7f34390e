#include "dataset/rle.h"

#include <algorithm>

namespace ensonify {

std::optional<std::vector<std::int64_t>> run_lengths(std::string_view counts, std::int64_t pixels) {
  std::vector<std::int64_t> runs;
  std::int64_t sum = 0;
  for (std::size_t at = 0; at < counts.size();) {
    std::int64_t value = 0;
    int shift = 0;
    for (bool more = true; more;) {
      if (at == counts.size() || shift > 50) return std::nullopt;
      const int bits = counts[at++] - 48;
      if (bits < 0 || bits > 63) return std::nullopt;
      value |= std::int64_t{bits & 0x1f} << shift;
      shift += 5;
      more = (bits & 0x20) != 0;
      if (!more && (bits & 0x10) != 0) value -= std::int64_t{1} << shift;
    }
    if (runs.size() > 2) value += runs[runs.size() - 2];
    if (value < 0 || value > pixels - sum) return std::nullopt;
    sum += value;
    runs.push_back(value);
  }
  if (sum != pixels) return std::nullopt;
  return runs;
}

std::optional<MaskExtent> mask_extent(std::string_view text, std::int64_t rows,
                                      std::int64_t columns) {
  if (rows < 1 || columns < 1) return std::nullopt;
  const auto counts = run_lengths(text, rows * columns);
  if (!counts) return std::nullopt;
  std::int64_t at = 0, area = 0, left = columns, right = -1, top = rows, bottom = -1;
  for (std::size_t i = 0; i < counts->size(); ++i) {
    const std::int64_t count = (*counts)[i];
    if (i % 2 == 1 && count > 0) {
      const std::int64_t last = at + count - 1;
      const bool one_column = at / rows == last / rows;
      left = std::min(left, at / rows);
      right = std::max(right, last / rows);
      top = std::min(top, one_column ? at % rows : 0);
      bottom = std::max(bottom, one_column ? last % rows : rows - 1);
      area += count;
    }
    at += count;
  }
  if (area == 0) return MaskExtent{};
  return MaskExtent{{left, top, right - left + 1, bottom - top + 1}, area};
}

}  // namespace ensonify
