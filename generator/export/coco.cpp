// The COCO layout that detectors load: images/SPLIT/*.png of one view, and their boxes and masks in
// annotations/instances_SPLIT.json. Category ids are the class ids of the data set.
#include "dataset/coco.h"

#include <map>

#include "export/job.h"
#include "formats/output_place.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

using CocoFiles = std::map<std::string, CocoFile>;  // by split

// Categories of the classes that are written.
Json written_categories(const ExportJob& job) {
  const Json all = categories_json(job.dataset.classes, job.dataset.class_kinds);
  Json written = Json::array();
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (job.objects.classes[k]) written.push_back(all[k]);
  }
  return written;
}

Status write_coco_ping(const ExportJob& job, const fs::path& target, const StoredSequence& sequence,
                       const StoredPing& ping, CocoFiles& files) {
  const auto grey = path_of(job, sequence, ping, grey_of(job));
  if (!grey) return grey.error();
  const auto picture = picture_of_view(job, sequence, ping, job.view());
  if (!picture) return picture.error();
  CocoImage image{picture->view, item_name(job, sequence, ping) + grey->extension().string(), {}};
  const Json of_run = run_members(job);
  for (const auto& [name, value] : of_run.items()) {
    image.more += "," + quoted_text(name) + ":" + value.dump();
  }
  for (const StoredAnnotation& annotation : picture->annotations) {
    image.instances.push_back(annotation.instance);
  }
  const std::string& split = sequence.row.split;
  const Status added = files.at(split).add(sequence.manifest.info, ping.annotation_line, image);
  return added ? copy_whole(*grey, target / "images" / split / image.file_name) : added;
}

}  // namespace

Status write_coco_folder(const ExportJob& job, const fs::path& target) {
  const Json categories = written_categories(job);
  CocoFiles files;
  for (const std::string& split : splits_of(job)) {
    for (const fs::path& folder : {target / "annotations", target / "images" / split}) {
      std::error_code error;
      fs::create_directories(folder, error);
      if (error) return write_error(folder, error.value());
    }
    files.try_emplace(split, target / "annotations" / ("instances_" + split + ".json"),
                      job.dataset.name, categories);
  }
  const Status written = for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    if (const Status there = need(job, sequence, grey_of(job)); !there) return there;
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return write_coco_ping(job, target, sequence, ping, files);
    });
  });
  if (!written) return written;
  for (auto& [split, file] : files) {
    if (const Status closed = file.close(); !closed) return closed;
  }
  return {};
}

}  // namespace ensonify
