// SPLIT/noisy/NAME.png and SPLIT/clean/NAME.png for training denoisers: the 8-bit image of a ping,
// and the same display of its expected level (clean_db), without speckle and noise.
#include <algorithm>
#include <optional>

#include "dataset/layout.h"
#include "dataset/read_pictures.h"
#include "export/job.h"
#include "formats/output.h"
#include "formats/png.h"
#include "labels/cartesian_display.h"
#include "labels/display.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

// How a sequence's images are displayed.
struct PairDisplay {
  DisplayTable table;
  std::vector<std::int32_t> map;         // of Cartesian images; empty: polar
  std::optional<Footprints> footprints;  // unless they show the nearest polar pixel
  std::vector<float> gains;
};

DisplayTable table_of(const Display& display, const StoredSequence& sequence) {
  return display_table(display, sequence.manifest.info.water.absorption_db_m, sequence.range_step_m,
                       static_cast<int>(sequence.samples), sequence.first_range_m);
}

Result<PairDisplay> display_of(const ExportJob& job, const Display& display,
                               const StoredSequence& sequence) {
  PairDisplay shown{table_of(display, sequence), {}, {}, {}};
  if (job.view() == PictureView::polar) return shown;
  auto map = read_cartesian_map(job.dataset, sequence);
  if (!map) return map.error();
  shown.map = std::move(*map);
  if (display.resampling == Resampling::nearest) return shown;
  const SequenceInfo& info = sequence.manifest.info;
  if (!is_grid_of_fan(*info.cartesian, info.sonar, info.water, info.record)) {
    return damaged(job.dataset.dir / layout::sequence_folder(sequence.row.sequence),
                   "has a Cartesian grid that is larger than its fan");
  }
  shown.footprints = footprints(*info.cartesian, info.sonar, info.water, info.record, shown.map);
  shown.gains = cartesian_gains(shown.table, *shown.footprints);
  return shown;
}

GreyImage through_map(const GreyImage& polar, const PairDisplay& shown,
                      const StoredSequence& sequence) {
  GreyImage image{static_cast<int>(sequence.cartesian_height),
                  static_cast<int>(sequence.cartesian_width),
                  std::vector<std::uint8_t>(shown.map.size())};
  for (std::size_t i = 0; i < shown.map.size(); ++i) {
    if (shown.map[i] >= 0) image.pixels[i] = polar.pixels[static_cast<std::size_t>(shown.map[i])];
  }
  return image;
}

// An automatic gain is that of the measured level.
Result<GreyImage> clean_image(const ExportJob& job, const PairDisplay& shown,
                              const StoredSequence& sequence, std::uint32_t ping) {
  const auto pixels = read_picture(job.dataset, sequence, ImageView::polar, ping,
                                   {"level_db", "clean_db", "elevation_rad"});
  if (!pixels) return pixels.error();
  const int rows = static_cast<int>(sequence.samples), columns = static_cast<int>(sequence.beams);
  Display display = shown.table.display;
  if (display.automatic_gain) {
    display.gain_db = displayed(shown.table, rows, columns, pixels->level_db, pixels->elevation_rad)
                          .further_gain_db;
    display.automatic_gain = false;
  }
  const DisplayTable table = table_of(display, sequence);
  DisplayedImage polar = displayed(table, rows, columns, pixels->clean_db, pixels->elevation_rad);
  if (shown.footprints) {
    return displayed_cartesian(table, *shown.footprints, shown.gains, polar.further_gain_db,
                               pixels->clean_db);
  }
  return shown.map.empty() ? std::move(polar.grey) : through_map(polar.grey, shown, sequence);
}

Status write_pair(const ExportJob& job, const fs::path& folder, const PairDisplay& shown,
                  const StoredSequence& sequence, const StoredPing& ping) {
  const std::string name = item_name(sequence, ping) + ".png";
  const auto noisy = path_of(job, sequence, ping, grey_of(job));
  if (!noisy) return noisy.error();
  const auto clean = clean_image(job, shown, sequence, ping.ping);
  if (!clean) return clean.error();
  const auto png = encode_png(clean->pixels, clean->rows, clean->columns);
  if (!png) return png.error();
  const Status copied = copy_whole(*noisy, folder / "noisy" / name);
  return copied ? write_whole(folder / "clean" / name, *png) : copied;
}

}  // namespace

Status write_pairs(const ExportJob& job, const fs::path& target) {
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    for (const CatalogueRow* row : {&grey_of(job), &plane_row(ImageView::polar, "level_db")}) {
      if (const Status there = need(job, sequence, *row); !there) return there;
    }
    const Display& display = job.render ? job.render->display : sequence.manifest.info.png;
    const auto shown = display_of(job, display, sequence);
    if (!shown) return shown.error();
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return write_pair(job, target / sequence.row.split, *shown, sequence, ping);
    });
  });
}

}  // namespace ensonify
