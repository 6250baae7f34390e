// MOTChallenge: SPLIT/SEQUENCE/img1/FFFFFF.png (.jpg of a JPEG render), gt/gt.txt and seqinfo.ini,
// and seqmaps/SPLIT.txt, a list of sequences for TrackEval. Frames, pixels and tracks count from 1;
// a track is an instance. A line of gt.txt is
//   frame, track, left, top, width, height, 1, 1, visible share
// where the first 1 means that the box is evaluated. The second is the class, which must be 1 for
// TrackEval; gt/tracks.csv has the classes of the tracks.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "dataset/mask.h"
#include "export/job.h"
#include "formats/csv.h"
#include "formats/files.h"
#include "formats/output_place.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

// Of the pixels that the instance would have alone; 1 where these are not known.
double visible_share(const StoredAnnotation& annotation, const Mask& mask) {
  if (annotation.amodal_area && *annotation.amodal_area > 0) {
    return static_cast<double>(mask.area) / static_cast<double>(*annotation.amodal_area);
  }
  return 1;
}

std::string track_lines(const StoredPicture& picture, std::uint64_t frame) {
  std::string lines;
  for (const StoredAnnotation& annotation : picture.annotations) {
    const Mask mask = mask_of(annotation.runs, static_cast<std::int64_t>(picture.height));
    lines +=
        fmt::format("{},{},{},{},{},{},1,1,{:.4g}\n", frame, annotation.instance, mask.left + 1,
                    mask.top + 1, mask.width, mask.height, visible_share(annotation, mask));
  }
  return lines;
}

std::string tracks_table(const ExportJob& job, const StoredSequence& sequence) {
  std::string table = "track,class_id,class,name\n";
  for (const StoredInstance& instance : sequence.instances) {
    if (!job.objects.classes[instance.class_id - 1U]) continue;
    table +=
        fmt::format("{},{},{},{}\n", instance.id, instance.class_id,
                    csv_cell(job.dataset.classes[instance.class_id - 1U]), csv_cell(instance.name));
  }
  return table;
}

// What seqinfo.ini needs from the pings.
struct Film {
  std::uint64_t frames = 0, width = 0, height = 0;
  double first_s = 0, last_s = 0;
  std::string extension = ".png";
};

// Readers expect a whole number.
std::int64_t frame_rate(const Film& film) {
  const double span_s = film.last_s - film.first_s;
  if (!(span_s > 0)) return 1;
  const double rate = std::round(static_cast<double>(film.frames - 1) / span_s);
  return static_cast<std::int64_t>(std::clamp(rate, 1.0, 1e6));
}

std::string seqinfo_text(const std::string& name, const Film& film) {
  return fmt::format(
      "[Sequence]\nname={}\nimDir=img1\nframeRate={}\nseqLength={}\nimWidth={}\nimHeight={}\n"
      "imExt={}\n",
      name, frame_rate(film), film.frames, film.width, film.height, film.extension);
}

Status write_mot_sequence(const ExportJob& job, const fs::path& folder,
                          const StoredSequence& sequence) {
  StreamedFile truth(folder / "gt" / "gt.txt");
  Film film;
  const Status read = for_each_exported_ping(job, sequence, [&](const StoredPing& ping) -> Status {
    const auto picture = picture_of_view(job, sequence, ping, job.view());
    if (!picture) return picture.error();
    const auto grey = path_of(job, sequence, ping, grey_of(job));
    if (!grey) return grey.error();
    if (film.frames++ == 0) film.first_s = ping.time_s;
    film.last_s = ping.time_s;
    film.width = picture->width;
    film.height = picture->height;
    film.extension = grey->extension().string();
    truth.append(track_lines(*picture, film.frames));
    const std::string name = fmt::format("{:06}{}", film.frames, film.extension);
    return copy_whole(*grey, folder / "img1" / name);
  });
  if (!read) return read;
  Status done = truth.close();
  if (done) done = write_whole(folder / "gt" / "tracks.csv", tracks_table(job, sequence));
  if (!done) return done;
  return write_whole(folder / "seqinfo.ini", seqinfo_text(folder.filename().string(), film));
}

}  // namespace

Status write_mot(const ExportJob& job, const fs::path& target) {
  std::map<std::string, std::string> lists;
  for (const std::string& split : splits_of(job)) lists[split] = "name\n";
  const Status written = for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    if (const Status there = need(job, sequence, grey_of(job)); !there) return there;
    const std::string name = fmt::format("{:06}", sequence.row.sequence);
    lists[sequence.row.split] += name + "\n";
    return write_mot_sequence(job, target / sequence.row.split / name, sequence);
  });
  if (!written) return written;
  for (const auto& [split, list] : lists) {
    const Status listed = write_whole(target / "seqmaps" / (split + ".txt"), list);
    if (!listed) return listed;
  }
  return {};
}

}  // namespace ensonify
