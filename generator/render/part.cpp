#include "render/part.h"

#include <fmt/format.h>

#include <algorithm>

#include "dataset/layout.h"

namespace ensonify {
namespace {

// Middle of the block [first, first + size), which `end` may cut short.
std::size_t middle(std::size_t first, std::size_t size, std::size_t end) {
  return first + (std::min(size, end - first) - 1) / 2;
}

Error refused(const StoredSequence& sequence, const std::string& what) {
  return {ErrorKind::usage,
          fmt::format("{}: {}", layout::sequence_folder(sequence.row.sequence), what)};
}

}  // namespace

Result<SequencePart> sequence_part(const ShownPart& shown, const StoredSequence& sequence) {
  SequencePart part{shown, sequence.beams, 0, sequence.samples, 0, 0, {}, {}};
  const auto range_m = [&](std::size_t n) {
    return sequence.first_range_m + static_cast<double>(n) * sequence.range_step_m;
  };
  if (shown.range_m) {
    const auto [from, to] = *shown.range_m;
    while (part.first < part.end && range_m(part.first) < from) ++part.first;
    while (part.end > part.first && range_m(part.end - 1) > to) --part.end;
    if (part.first == part.end) {
      return refused(sequence, fmt::format("--range {:g}:{:g}: holds no sample; expected a part of "
                                           "{:.2f} to {:.2f} m",
                                           from, to, range_m(0), range_m(sequence.samples - 1)));
    }
  }
  const std::size_t samples = part.end - part.first;
  if (shown.samples > samples) {
    return refused(sequence, fmt::format("--every-sample {}: the images have {} samples; expected "
                                         "at most as many",
                                         shown.samples, samples));
  }
  if (shown.beams > part.beams) {
    return refused(sequence, fmt::format("--every-beam {}: the images have {} beams; expected at "
                                         "most as many",
                                         shown.beams, part.beams));
  }
  part.rows = (samples + shown.samples - 1) / shown.samples;
  part.columns = (part.beams + shown.beams - 1) / shown.beams;
  part.polar = {part.first, 0, part.rows, part.columns};
  return part;
}

DisplayTable part_of_table(const DisplayTable& table, const SequencePart& part) {
  DisplayTable cut = table;
  cut.tvg_db.clear();
  for (std::size_t row = 0; row < part.rows; ++row) {
    const std::size_t first = part.first + row * part.shown.samples;
    cut.tvg_db.push_back(table.tvg_db[middle(first, part.shown.samples, part.end)]);
  }
  return cut;
}

std::vector<std::uint32_t> block_pixels(const SequencePart& part, std::span<const float> level_db) {
  const std::size_t samples = part.shown.samples, beams = part.shown.beams;
  std::vector<std::uint32_t> pixels;
  pixels.reserve(part.rows * part.columns);
  for (std::size_t top = part.first; top < part.end; top += samples) {
    for (std::size_t left = 0; left < part.beams; left += beams) {
      if (part.shown.decimation == Decimation::pick) {
        const std::size_t at = middle(top, samples, part.end) * part.beams;
        pixels.push_back(static_cast<std::uint32_t>(at + middle(left, beams, part.beams)));
        continue;
      }
      std::size_t best = top * part.beams + left;
      for (std::size_t n = top; n < std::min(top + samples, part.end); ++n) {
        for (std::size_t m = left; m < std::min(left + beams, part.beams); ++m) {
          if (level_db[n * part.beams + m] > level_db[best]) best = n * part.beams + m;
        }
      }
      pixels.push_back(static_cast<std::uint32_t>(best));
    }
  }
  return pixels;
}

std::vector<float> held(const SequencePart& part, std::span<const std::uint32_t> pixels,
                        std::span<const float> level_db) {
  std::vector<float> levels(level_db.begin(), level_db.end());
  for (std::size_t n = part.first; n < part.end; ++n) {
    const std::size_t row = (n - part.first) / part.shown.samples;
    for (std::size_t m = 0; m < part.beams; ++m) {
      levels[n * part.beams + m] = level_db[pixels[row * part.columns + m / part.shown.beams]];
    }
  }
  return levels;
}

Result<std::vector<std::int32_t>> part_of_map(SequencePart& part, std::span<const std::int32_t> map,
                                              const StoredSequence& sequence) {
  const std::size_t height = sequence.cartesian_height, width = sequence.cartesian_width;
  const auto is_shown = [&](std::int32_t pixel) {
    const auto sample = static_cast<std::size_t>(std::max(pixel, 0)) / part.beams;
    return pixel >= 0 && sample >= part.first && sample < part.end;
  };
  std::size_t top = height, bottom = 0, left = width, right = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (!is_shown(map[i])) continue;
    top = std::min(top, i / width);
    bottom = std::max(bottom, i / width + 1);
    left = std::min(left, i % width);
    right = std::max(right, i % width + 1);
  }
  if (top >= bottom) {
    return refused(
        sequence, "--range: holds no pixel of the Cartesian images; widen it, or use --view polar");
  }
  part.cartesian = {top, left, bottom - top, right - left};
  std::vector<std::int32_t> cut;
  cut.reserve((bottom - top) * (right - left));
  for (std::size_t row = top; row < bottom; ++row) {
    for (std::size_t column = left; column < right; ++column) {
      const std::int32_t pixel = map[row * width + column];
      if (!is_shown(pixel)) {
        cut.push_back(-1);
        continue;
      }
      const auto at = static_cast<std::size_t>(pixel);
      cut.push_back(static_cast<std::int32_t>((at / part.beams - part.first) / part.shown.samples *
                                                  part.columns +
                                              at % part.beams / part.shown.beams));
    }
  }
  return cut;
}

GreyImage cut(const SequencePart& part, const GreyImage& image, std::span<const std::int32_t> map) {
  const PartPixels& of = part.cartesian;
  GreyImage shown{static_cast<int>(of.height_px), static_cast<int>(of.width_px), {}};
  shown.pixels.reserve(map.size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    const std::size_t row = of.top_px + i / of.width_px, column = of.left_px + i % of.width_px;
    const std::uint8_t gray = image.pixels[row * static_cast<std::size_t>(image.columns) + column];
    shown.pixels.push_back(map[i] < 0 ? 0 : gray);
  }
  return shown;
}

}  // namespace ensonify
