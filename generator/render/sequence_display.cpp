#include "render/sequence_display.h"

#include "dataset/layout.h"
#include "dataset/read_pictures.h"
#include "render/image.h"

namespace ensonify {

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

}  // namespace ensonify
