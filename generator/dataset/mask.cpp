#include "dataset/mask.h"

#include <algorithm>
#include <array>
#include <bit>

namespace ensonify {
namespace {

// Directions, clockwise with rows downwards: right, down, left, up.
constexpr std::array<Corner, 4> kSteps = {Corner{1, 0}, Corner{0, 1}, Corner{-1, 0}, Corner{0, -1}};

// The edges between pixels of the mask and others, each from its beginning: bit d of a corner means
// that an edge leaves it in direction d. The mask lies to the right of each edge.
class Edges {
 public:
  explicit Edges(const Mask& mask) : columns_(mask.width + 1), rows_(mask.height + 1) {
    leaving_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    const auto is_set = [&](int x, int y) {
      return x >= 0 && y >= 0 && x < mask.width && y < mask.height &&
             mask.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width) +
                         static_cast<std::size_t>(x)] != 0;
    };
    for (int y = 0; y < mask.height; ++y) {
      for (int x = 0; x < mask.width; ++x) {
        if (!is_set(x, y)) continue;
        if (!is_set(x, y - 1)) at({x, y}) |= 1;
        if (!is_set(x + 1, y)) at({x + 1, y}) |= 2;
        if (!is_set(x, y + 1)) at({x + 1, y + 1}) |= 4;
        if (!is_set(x - 1, y)) at({x, y + 1}) |= 8;
      }
    }
  }

  // Returns every loop, in the order of its first corner, rows first; consumes the edges.
  std::vector<std::vector<Corner>> loops() {
    std::vector<std::vector<Corner>> loops;
    for (int y = 0; y < rows_; ++y) {
      for (int x = 0; x < columns_; ++x) {
        while (at({x, y}) != 0) loops.push_back(loop_from({x, y}));
      }
    }
    return loops;
  }

 private:
  std::uint8_t& at(Corner corner) {
    return leaving_[static_cast<std::size_t>(corner.y) * static_cast<std::size_t>(columns_) +
                    static_cast<std::size_t>(corner.x)];
  }
  int take(Corner corner, int direction) {
    at(corner) = static_cast<std::uint8_t>(at(corner) & ~(1 << direction));
    return direction;
  }
  // Prefers right, then straight on, then left, so that the loop stays with its pixel where two
  // pixels touch only at a corner.
  int leave(Corner corner, int direction) {
    for (const int turn : {1, 0, 3}) {
      const int next = (direction + turn) % 4;
      if ((at(corner) & 1 << next) != 0) return take(corner, next);
    }
    return -1;
  }
  std::vector<Corner> loop_from(Corner start) {
    std::vector<Corner> corners;
    Corner here = start;
    for (int direction = take(here, std::countr_zero(at(here))), last = -1; direction >= 0;) {
      if (direction != last) corners.push_back(here);
      last = direction;
      here = {here.x + kSteps[static_cast<std::size_t>(direction)].x,
              here.y + kSteps[static_cast<std::size_t>(direction)].y};
      if (here == start) break;
      direction = leave(here, direction);
    }
    return corners;
  }

  int columns_, rows_;
  std::vector<std::uint8_t> leaving_;
};

}  // namespace

Mask mask_of(std::span<const std::int64_t> runs, std::int64_t picture_height) {
  // Calls use(column, first row, rows) for every piece of a run of ones that lies in one column.
  const auto for_each_piece = [&](const auto& use) {
    std::int64_t at = 0;
    for (std::size_t i = 0; i < runs.size(); at += runs[i++]) {
      if (i % 2 == 0) continue;
      for (std::int64_t pixel = at; pixel < at + runs[i];) {
        const std::int64_t row = pixel % picture_height;
        const std::int64_t count = std::min(picture_height - row, at + runs[i] - pixel);
        use(static_cast<int>(pixel / picture_height), static_cast<int>(row),
            static_cast<int>(count));
        pixel += count;
      }
    }
  };
  Mask mask;
  int right = 0, bottom = 0;
  for_each_piece([&](int column, int row, int count) {
    const bool first = mask.area == 0;
    mask.left = first ? column : mask.left;
    mask.top = first ? row : std::min(mask.top, row);
    right = column + 1;
    bottom = std::max(bottom, row + count);
    mask.area += count;
  });
  if (mask.area == 0) return mask;
  mask.width = right - mask.left;
  mask.height = bottom - mask.top;
  mask.pixels.resize(static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height));
  for_each_piece([&](int column, int row, int count) {
    for (int y = row - mask.top; y < row - mask.top + count; ++y) {
      mask.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width) +
                  static_cast<std::size_t>(column - mask.left)] = 1;
    }
  });
  return mask;
}

std::vector<std::vector<Corner>> rings_of(const Mask& mask) {
  auto rings = Edges(mask).loops();
  for (auto& ring : rings) {
    for (Corner& corner : ring) {
      corner.x += mask.left;
      corner.y += mask.top;
    }
  }
  return rings;
}

std::vector<Corner> outline_of(const Mask& mask) {
  const auto loops = rings_of(mask);
  std::vector<Corner> outline;
  for (const auto& loop : loops) {
    outline.insert(outline.end(), loop.begin(), loop.end());
    if (loops.size() > 1) outline.push_back(loop.front());
  }
  for (std::size_t i = loops.size(); i-- > 1;) {
    if (i > 1) outline.push_back(loops[i - 1].front());
  }
  return outline;
}

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
