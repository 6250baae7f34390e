// A2FNet's lists: each line of label_SPLIT.txt names the files of a ping, separated by blanks and
// relative to the list:
//   sonar/NAME.png      the 8-bit polar image: rows samples, nearest first; columns beams
//   front/NAME.png      front view, 8 bits: 1/r, from 0 at range_max_m to 255 at range_min_m
//   front_hd/NAME.txt   front view as text, a row of numbers a line: 1/r in 1/m, 0: no surface
//   elevation/NAME.png  8 bits, as the sonar image: 1 + 254 (elevation + fan/2)/fan, 0: no echo
// Rows of front views are elevations, lowest first, columns are azimuths, starboard first.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <span>
#include <utility>

#include "dataset/read_pictures.h"
#include "export/job.h"
#include "formats/bytes.h"
#include "formats/output_place.h"
#include "formats/png.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

const CatalogueRow& grey_polar() { return grey_row(ImageView::polar); }
const CatalogueRow& front_range() { return *find_array("front_range_m.npy"); }

// From `lowest` at 0 and below to 255 at 1 and above.
std::uint8_t scaled(double part, double lowest) {
  const double inside = part > 0 ? std::min(part, 1.0) : 0;
  return static_cast<std::uint8_t>(std::lround(lowest + inside * (255 - lowest)));
}

std::string inverse_text(std::span<const float> range_m, std::size_t columns) {
  std::string text;
  for (std::size_t i = 0; i < range_m.size(); ++i) {
    const double inverse = range_m[i] > 0 ? 1.0 / static_cast<double>(range_m[i]) : 0;
    fmt::format_to(std::back_inserter(text), "{:.6g}{}", inverse,
                   (i + 1) % columns == 0 ? '\n' : ' ');
  }
  return text;
}

std::vector<std::uint8_t> inverse_image(std::span<const float> range_m,
                                        const StoredSequence& sequence) {
  const Sonar& sonar = sequence.manifest.info.sonar;
  const double nearest = 1 / std::max(sonar.range_min_m, sequence.range_step_m);
  const double farthest = 1 / sonar.range_max_m;
  std::vector<std::uint8_t> pixels;
  for (const float range : range_m) {
    const double inverse = range > 0 ? 1 / static_cast<double>(range) : farthest;
    pixels.push_back(scaled((inverse - farthest) / (nearest - farthest), 0));
  }
  return pixels;
}

std::vector<std::uint8_t> elevation_image(std::span<const float> elevation_rad, double fan_rad) {
  std::vector<std::uint8_t> pixels;
  for (const float elevation : elevation_rad) {
    const double part = static_cast<double>(elevation) / fan_rad + 0.5;
    pixels.push_back(std::isnan(elevation) ? std::uint8_t{0} : scaled(part, 1));
  }
  return pixels;
}

template <class Pixels>
Status write_png(const fs::path& path, const Pixels& pixels, std::uint64_t rows,
                 std::uint64_t columns) {
  const auto bytes = encode_png(pixels, static_cast<int>(rows), static_cast<int>(columns));
  return bytes ? write_whole(path, *bytes) : Status(bytes.error());
}

Status write_ping_files(const ExportJob& job, const fs::path& target,
                        const StoredSequence& sequence, const StoredPing& ping) {
  const std::string name = item_name(job, sequence, ping);
  const auto grey = path_of(job, sequence, ping, grey_polar());
  if (!grey) return grey.error();
  const auto bytes = CellReader(job.dataset, sequence, ping.ping).read(front_range());
  if (!bytes) return bytes.error();
  const auto labels =
      read_picture(job.dataset, sequence, ImageView::polar, ping.ping, {"elevation_rad"});
  if (!labels) return labels.error();
  const auto range_m = values_in<float>(*bytes);
  const double fan_rad = sequence.manifest.info.sonar.elevation_fan_rad;
  Status done = copy_whole(*grey, target / "sonar" / (name + ".png"));
  if (done) {
    done = write_png(target / "front" / (name + ".png"), inverse_image(range_m, sequence),
                     sequence.ray_elevations, sequence.ray_azimuths);
  }
  if (done) {
    done = write_whole(target / "front_hd" / (name + ".txt"),
                       inverse_text(range_m, sequence.ray_azimuths));
  }
  if (!done) return done;
  return write_png(target / "elevation" / (name + ".png"),
                   elevation_image(labels->elevation_rad, fan_rad), sequence.samples,
                   sequence.beams);
}

}  // namespace

Status write_a2fnet(const ExportJob& job, const fs::path& target) {
  std::map<std::string, std::string> lists;
  for (const std::string& split : splits_of(job)) lists[split];
  const Status written = for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    for (const CatalogueRow* row :
         {&grey_polar(), &plane_row(ImageView::polar, "elevation_rad"), &front_range()}) {
      if (const Status there = need(job, sequence, *row); !there) return there;
    }
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      lists[sequence.row.split] +=
          fmt::format("sonar/{0}.png front/{0}.png front_hd/{0}.txt elevation/{0}.png\n",
                      item_name(job, sequence, ping));
      return write_ping_files(job, target, sequence, ping);
    });
  });
  if (!written) return written;
  for (const auto& [split, lines] : lists) {
    const Status listed = write_whole(target / fmt::format("label_{}.txt", split), lines);
    if (!listed) return listed;
  }
  return {};
}

}  // namespace ensonify
