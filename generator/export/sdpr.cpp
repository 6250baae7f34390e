// SPLIT/imgs/N.jpeg and SPLIT/poses/N.txt, as sdpr reads paths (Donadi et al., "Improving
// generalization of synthetically trained sonar image descriptors for underwater place
// recognition", 2023), and SPLIT/pings.csv, the ping of each number N. Images are polar, port on
// the left: the reader takes angles to grow clockwise with the column. A pose has a line `x y z`
// and a line `qx qy qz qw`, sonar to world.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <vector>

#include "export/job.h"
#include "formats/files.h"
#include "formats/jpeg.h"
#include "formats/output_place.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr int kQuality = 95;

// A folder train_dir or test_dir of the reader.
struct PlaceFolder {
  PlaceFolder(fs::path at, bool has_runs) : folder(std::move(at)), list(folder / "pings.csv") {
    list.append(has_runs ? "number,run,sequence,ping\n" : "number,sequence,ping\n");
  }
  fs::path folder;
  StreamedFile list;
  std::uint64_t images = 0;
};

std::string pose_text(const Pose& pose) {
  const Vec3& p = pose.position_m;
  const Quat& q = pose.rotation;
  return fmt::format("{} {} {}\n{} {} {} {}\n", p.x, p.y, p.z, q.x, q.y, q.z, q.w);
}

Result<std::string> jpeg_of(const ExportJob& job, const StoredSequence& sequence,
                            const StoredPing& ping) {
  const auto path = path_of(job, sequence, ping, grey_row(ImageView::polar));
  if (!path) return path.error();
  auto grey = grey_pixels(job, *path, sequence.samples, sequence.beams);
  if (!grey) return grey.error();
  const auto beams = static_cast<std::ptrdiff_t>(sequence.beams);
  for (auto row = grey->begin(); row != grey->end(); row += beams) {
    std::reverse(row, row + beams);
  }
  return encode_grey_jpeg(*grey, static_cast<int>(sequence.samples), static_cast<int>(beams),
                          kQuality);
}

Status write_place(const ExportJob& job, PlaceFolder& place, const StoredSequence& sequence,
                   const StoredPing& ping) {
  const auto jpeg = jpeg_of(job, sequence, ping);
  if (!jpeg) return jpeg.error();
  const std::string number = std::to_string(place.images++);
  const std::string run = job.sweep != nullptr ? job.sweep->current->id + "," : "";
  place.list.append(fmt::format("{},{}{},{}\n", number, run, sequence.row.sequence, ping.ping));
  const Status written = write_whole(place.folder / "imgs" / (number + ".jpeg"), *jpeg);
  if (!written) return written;
  return write_whole(place.folder / "poses" / (number + ".txt"), pose_text(ping.sonar_in_world));
}

}  // namespace

Status write_sdpr(const ExportJob& job, const fs::path& target) {
  std::map<std::string, std::unique_ptr<PlaceFolder>> places;
  const Status written = for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    const Status there = need(job, sequence, grey_row(ImageView::polar));
    if (!there) return there;
    auto& place = places[sequence.row.split];
    if (!place)
      place = std::make_unique<PlaceFolder>(target / sequence.row.split, job.sweep != nullptr);
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return write_place(job, *place, sequence, ping);
    });
  });
  if (!written) return written;
  for (auto& [split, place] : places) {
    if (const Status closed = place->list.close(); !closed) return closed;
  }
  return {};
}

}  // namespace ensonify
