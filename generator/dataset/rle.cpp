#include "dataset/rle.h"

#include <algorithm>
#include <vector>

namespace ensonify {
namespace {

// Counts of zeros and ones in turn; none where the text is no such code.
std::optional<std::vector<std::int64_t>> run_lengths(std::string_view text) {
  std::vector<std::int64_t> counts;
  for (std::size_t i = 0; i < text.size();) {
    std::int64_t value = 0;
    int shift = 0;
    for (bool more = true; more; ++i, shift += 5) {
      if (i == text.size() || shift > 50) return std::nullopt;
      const int group = text[i] - 48;
      if (group < 0 || group > 63) return std::nullopt;
      value |= std::int64_t{group & 0x1f} << shift;
      more = (group & 0x20) != 0;
      if (!more && (group & 0x10) != 0) value -= std::int64_t{1} << (shift + 5);
    }
    if (counts.size() > 2) value += counts[counts.size() - 2];
    if (value < 0) return std::nullopt;
    counts.push_back(value);
  }
  return counts;
}

}  // namespace

std::optional<MaskExtent> mask_extent(std::string_view text, std::int64_t rows,
                                      std::int64_t columns) {
  const auto counts = run_lengths(text);
  if (!counts || rows < 1 || columns < 1) return std::nullopt;
  std::int64_t at = 0, area = 0, left = columns, right = -1, top = rows, bottom = -1;
  for (std::size_t i = 0; i < counts->size(); ++i) {
    const std::int64_t count = (*counts)[i];
    if (count > rows * columns - at) return std::nullopt;
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
  if (at != rows * columns) return std::nullopt;
  if (area == 0) return MaskExtent{};
  return MaskExtent{{left, top, right - left + 1, bottom - top + 1}, area};
}

}  // namespace ensonify
