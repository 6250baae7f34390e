// SPLIT/noisy/NAME.png and SPLIT/clean/NAME.png for training denoisers: the 8-bit image of a ping,
// and the same display of its expected level (clean_db), without speckle and noise.
#include <utility>

#include "dataset/read_pictures.h"
#include "export/job.h"
#include "formats/output_place.h"
#include "formats/png.h"
#include "render/shown_images.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

// An automatic gain is that of the measured level.
Result<GreyImage> clean_image(const ExportJob& job, const SequenceDisplay& shown,
                              const StoredSequence& sequence, std::uint32_t ping) {
  auto pixels = read_picture(job.dataset, sequence, ImageView::polar, ping,
                             {"level_db", "clean_db", "elevation_rad"});
  if (!pixels) return pixels.error();
  DisplayTable table = shown.table;
  if (table.display.automatic_gain) {
    table.display.gain_db = shown_polar(sequence, shown, *pixels, {}).further_gain_db;
    table.display.automatic_gain = false;
  }
  pixels->level_db = std::move(pixels->clean_db);
  DisplayedImage polar =
      displayed(table, static_cast<int>(sequence.samples), static_cast<int>(sequence.beams),
                pixels->level_db, pixels->elevation_rad);
  if (shown.map.empty()) return std::move(polar.grey);
  return shown_cartesian(sequence, shown, *pixels, {}, polar);
}

Status write_pair(const ExportJob& job, const fs::path& folder, const SequenceDisplay& shown,
                  const StoredSequence& sequence, const StoredPing& ping) {
  const std::string name = item_name(job, sequence, ping) + ".png";
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
    const auto shown =
        sequence_display(job.dataset, sequence, display, {}, job.view() == PictureView::cartesian);
    if (!shown) return shown.error();
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return write_pair(job, target / sequence.row.split, *shown, sequence, ping);
    });
  });
}

}  // namespace ensonify
