// Ultralytics' layout: images/SPLIT/*.png, labels/SPLIT/*.txt, data.yaml.
// A label line is `class x y x y ...` (an outline) or `class x y width height` (a box and its
// centre), in parts of the picture's width and height; classes count from 0.
#include <fmt/format.h>

#include <array>

#include "dataset/files.h"
#include "dataset/mask.h"
#include "dataset/output.h"
#include "export/job.h"
#include "export/json_text.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

std::string part(double pixels, std::uint64_t side) {
  return fmt::format(" {:.7g}", pixels / static_cast<double>(side));
}

std::string label_line(const ExportJob& job, const StoredPicture& picture, const Mask& mask,
                       int class_id) {
  std::string line = std::to_string(class_id - 1);
  if (job.options.labels.value_or(YoloLabels::segments) == YoloLabels::boxes) {
    line += part(mask.left + mask.width / 2.0, picture.width) +
            part(mask.top + mask.height / 2.0, picture.height) + part(mask.width, picture.width) +
            part(mask.height, picture.height);
  } else {
    for (const Corner& corner : outline_of(mask)) {
      line += part(corner.x, picture.width) + part(corner.y, picture.height);
    }
  }
  return line + "\n";
}

Status write_yolo_ping(const ExportJob& job, const fs::path& target, const StoredSequence& sequence,
                       const StoredPing& ping) {
  const auto grey =
      ping_file(job.dataset, sequence.row.sequence, grey_template(job.view()), ping.ping);
  if (!grey) return grey.error();
  const auto picture = picture_of_view(job, sequence, ping, job.view());
  if (!picture) return picture.error();
  std::string labels;
  for (const StoredAnnotation& annotation : picture->annotations) {
    const Mask mask = mask_of(annotation.runs, static_cast<std::int64_t>(picture->height));
    if (mask.area == 0) continue;
    labels += label_line(job, *picture, mask, sequence.instances[annotation.instance - 1].class_id);
  }
  const std::string name = item_name(sequence, ping);
  const Status copied = copy_whole(*grey, target / "images" / sequence.row.split / (name + ".png"));
  if (!copied) return copied;
  return write_whole(target / "labels" / sequence.row.split / (name + ".txt"), labels);
}

Status write_data_yaml(const ExportJob& job, const fs::path& target) {
  std::string text = "# Paths are relative to this file.\n";
  for (const char* split : {"train", "val", "test"}) {
    text += fmt::format("{0}: images/{0}\n", split);
    for (const char* folder : {"images", "labels"}) {
      std::error_code error;
      fs::create_directories(target / folder / split, error);
      if (error) return write_error(target / folder / split, error.value());
    }
  }
  text += fmt::format("nc: {}\nnames:\n", job.dataset.classes.size());
  for (std::size_t i = 0; i < job.dataset.classes.size(); ++i) {
    text += fmt::format("  {}: {}\n", i, quoted_text(job.dataset.classes[i]));
  }
  return write_whole(target / "data.yaml", text);
}

}  // namespace

Status write_yolo(const ExportJob& job, const fs::path& target) {
  if (const Status written = write_data_yaml(job, target); !written) return written;
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    if (const Status there = need(job, sequence, grey_template(job.view())); !there) return there;
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return write_yolo_ping(job, target, sequence, ping);
    });
  });
}

}  // namespace ensonify
