#include "render/shown_images.h"

#include <fmt/format.h>

#include <algorithm>

#include "dataset/layout.h"
#include "dataset/read_pictures.h"
#include "figure/drawing.h"
#include "formats/jpeg.h"
#include "formats/png.h"

namespace ensonify {
namespace {

Palette palette_of(const ColourMap& map) {
  Palette palette{};
  for (std::size_t i = 0; i < palette.size(); ++i) {
    const Rgb8 color = colour_at(map, static_cast<double>(i) / 255);
    palette[i] = {color.red, color.green, color.blue};
  }
  return palette;
}

}  // namespace

GreyImage flipped(const GreyImage& image, Flip flip) {
  GreyImage turned = image;
  const auto columns = static_cast<std::ptrdiff_t>(image.columns);
  auto& pixels = turned.pixels;
  // Flipping both reverses the whole image.
  if (flip == Flip::both) std::reverse(pixels.begin(), pixels.end());
  for (std::ptrdiff_t row = 0; flip == Flip::horizontal && row < image.rows; ++row) {
    std::reverse(pixels.begin() + row * columns, pixels.begin() + (row + 1) * columns);
  }
  for (std::ptrdiff_t row = 0; flip == Flip::vertical && row < image.rows / 2; ++row) {
    std::swap_ranges(pixels.begin() + row * columns, pixels.begin() + (row + 1) * columns,
                     pixels.begin() + (image.rows - 1 - row) * columns);
  }
  return turned;
}

GreyImage mapped(const GreyImage& polar, std::span<const std::int32_t> map, int rows, int columns) {
  GreyImage image{rows, columns, std::vector<std::uint8_t>(map.size())};
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (map[i] >= 0) image.pixels[i] = polar.pixels[static_cast<std::size_t>(map[i])];
  }
  return image;
}

Result<std::string> encode_image(const GreyImage& image, const Display& display,
                                 std::uint32_t jpeg_quality) {
  if (jpeg_quality > 0) {
    auto bytes =
        encode_grey_jpeg(image.pixels, image.rows, image.columns, static_cast<int>(jpeg_quality));
    if (bytes) return bytes;
    return Error{ErrorKind::usage,
                 fmt::format("--jpeg-quality: {} x {} pixels: {}; leave the option "
                             "out, which writes PNG files",
                             image.columns, image.rows, bytes.error().message)};
  }
  if (display.color_map.empty()) return encode_png(image.pixels, image.rows, image.columns);
  const ColourMap* map = find_colour_map(display.color_map);
  ENSONIFY_ASSERT(map != nullptr);
  return encode_palette_png(image.pixels, image.rows, image.columns, palette_of(*map));
}

DisplayTable sequence_table(const Display& display, const StoredSequence& sequence) {
  return display_table(display, sequence.manifest.info.water.absorption_db_m, sequence.range_step_m,
                       static_cast<int>(sequence.samples), sequence.first_range_m);
}

Result<SequenceDisplay> sequence_display(const StoredDataset& dataset,
                                         const StoredSequence& sequence, const Display& display,
                                         const ShownPart& part_of, bool with_cartesian) {
  SequenceDisplay shown{sequence_table(display, sequence), {}, {}, {}, {}};
  if (!part_of.is_whole()) {
    auto part = sequence_part(part_of, sequence);
    if (!part) return part.error();
    shown.part = *part;
  }
  if (!with_cartesian) return shown;
  auto map = read_cartesian_map(dataset, sequence);
  if (!map) return map.error();
  shown.map = std::move(*map);
  const auto cut_map = [&]() -> Status {
    if (!shown.part) return {};
    auto cut = part_of_map(*shown.part, shown.map, sequence);
    if (!cut) return cut.error();
    shown.map = std::move(*cut);
    return {};
  };
  const SequenceInfo& info = sequence.manifest.info;
  if (display.resampling == Resampling::nearest) {
    const Status done = cut_map();
    return done ? Result<SequenceDisplay>(std::move(shown)) : done.error();
  }
  if (!is_grid_of_fan(*info.cartesian, info.sonar, info.water, info.record)) {
    return damaged(dataset.dir / layout::sequence_folder(sequence.row.sequence),
                   "has a Cartesian grid that is larger than its fan");
  }
  shown.footprints = footprints(*info.cartesian, info.sonar, info.water, info.record, shown.map);
  shown.gains = cartesian_gains(shown.table, *shown.footprints);
  const Status done = cut_map();
  return done ? Result<SequenceDisplay>(std::move(shown)) : done.error();
}

DisplayedImage shown_polar(const StoredSequence& sequence, const SequenceDisplay& shown,
                           const ImagePlanes& pixels, std::span<const std::uint32_t> blocks) {
  if (!shown.part) {
    return displayed(shown.table, static_cast<int>(sequence.samples),
                     static_cast<int>(sequence.beams), pixels.level_db, pixels.elevation_rad);
  }
  std::vector<float> level_db, elevation_rad;
  for (const std::uint32_t pixel : blocks) {
    level_db.push_back(pixels.level_db[pixel]);
    if (!pixels.elevation_rad.empty()) elevation_rad.push_back(pixels.elevation_rad[pixel]);
  }
  return displayed(part_of_table(shown.table, *shown.part), static_cast<int>(shown.part->rows),
                   static_cast<int>(shown.part->columns), level_db, elevation_rad);
}

GreyImage shown_cartesian(const StoredSequence& sequence, const SequenceDisplay& shown,
                          const ImagePlanes& pixels, std::span<const std::uint32_t> blocks,
                          const DisplayedImage& polar) {
  const auto smooth = [&](std::span<const float> level_db) {
    return displayed_cartesian(shown.table, *shown.footprints, shown.gains, polar.further_gain_db,
                               level_db);
  };
  if (shown.part && shown.footprints) {
    return cut(*shown.part, smooth(held(*shown.part, blocks, pixels.level_db)), shown.map);
  }
  if (shown.footprints) return smooth(pixels.level_db);
  const bool is_part = shown.part.has_value();
  return mapped(
      polar.grey, shown.map,
      static_cast<int>(is_part ? shown.part->cartesian.height_px : sequence.cartesian_height),
      static_cast<int>(is_part ? shown.part->cartesian.width_px : sequence.cartesian_width));
}

std::string display_warning(const Display& display, const DisplayCounts& counts,
                            const std::string& dataset) {
  const auto share = [](std::uint64_t part, std::uint64_t whole) {
    return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
  };
  const double white = share(counts.white, counts.all), black = share(counts.black, counts.echo);
  std::string shares;
  if (white > kMostWhite) shares = fmt::format("{:.1f} % of the pixels are white", 100 * white);
  if (black > kMostBlack) {
    shares += fmt::format("{}{:.1f} % of the pixels with echoes are black",
                          shares.empty() ? "" : " and ", 100 * black);
  }
  if (shares.empty()) return {};
  return fmt::format(
      "8-bit images: {} with limits of {:g} and {:g} dB; `ensonify render {} --name NAME --db "
      "MIN:MAX` makes the images again with other limits",
      shares, display.limits_db[0], display.limits_db[1], dataset);
}

}  // namespace ensonify
