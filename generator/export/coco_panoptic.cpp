// COCO's panoptic layout: images/SPLIT, annotations/panoptic_SPLIT.json, and for each image two
// masks, annotations/panoptic_SPLIT/NAME.png, whose pixels are ids of segments,
// R + 256 G + 65536 B, 0 none, and annotations/semantic_SPLIT/NAME.png, of class ids, 255 none.
//
// A segment is an instance of a thing, with its id as in the data set, or all stuff of a class,
// with the id 65536 + class id. Segments are those of the instance masks.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "dataset/coco.h"
#include "export/job.h"
#include "formats/files.h"
#include "formats/json.h"
#include "formats/output_place.h"
#include "formats/png.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr std::uint32_t kFirstStuffSegment = 65536;
constexpr std::uint8_t kNoClass = 255;

struct Segment {
  std::uint8_t class_id = 0;
  std::uint64_t area = 0;
  std::uint64_t left = 0, top = 0, right = 0, bottom = 0;  // pixels of the box, inclusive

  void add(std::uint64_t x, std::uint64_t y) {
    if (area++ == 0) {
      left = right = x;
      top = bottom = y;
    }
    left = std::min(left, x);
    right = std::max(right, x);
    bottom = y;  // rows come in order
  }
};

struct PanopticImage {
  std::vector<RgbPixel> ids;
  std::vector<std::uint8_t> classes;
  std::map<std::uint32_t, Segment> segments;  // by id
};

// The list of one JSON file, which is written piece by piece.
struct PanopticFile {
  StreamedFile file, annotations;
  std::uint64_t images = 0;

  PanopticFile(const fs::path& path, const std::string& opening)
      : file(path), annotations(path.string() + ".annotations") {
    file.append(opening);
  }
  void add(const Json& image, const Json& annotation) {
    const char* const before = images++ == 0 ? "\n" : ",\n";
    for (const auto& [to, line] : {std::pair(&file, &image), {&annotations, &annotation}}) {
      to->append(before);
      to->append(json_line(*line));
    }
  }
  Status close() {
    file.append("\n],\n\"annotations\": [");
    file.append_all_of(annotations);
    file.append("\n]\n}\n");
    return file.close();
  }
};

using PanopticFiles = std::map<std::string, PanopticFile>;  // by split

Json panoptic_categories(const ExportJob& job) {
  Json categories = categories_json(job.dataset.classes, job.dataset.class_kinds);
  const Palette colors = voc_palette();
  for (std::size_t k = 0; k < categories.size(); ++k) categories[k]["color"] = colors[k + 1];
  return categories;
}

Result<PanopticImage> panoptic_image(const ExportJob& job, const StoredSequence& sequence,
                                     const fs::path& mask, std::uint64_t rows,
                                     std::uint64_t columns) {
  const auto instances = read_grey16(mask, rows, columns);
  if (!instances) return instances.error();
  PanopticImage image;
  image.ids.resize(instances->size());
  image.classes.assign(instances->size(), kNoClass);
  for (std::size_t i = 0; i < instances->size(); ++i) {
    const std::uint32_t instance = (*instances)[i];
    if (instance == 0) continue;
    if (instance > sequence.instances.size()) {
      return damaged(mask,
                     fmt::format("names instance {} of {}", instance, sequence.instances.size()));
    }
    const std::uint8_t class_id = sequence.instances[instance - 1].class_id;
    const bool is_stuff = job.dataset.class_kinds[class_id - 1U] == ClassKind::stuff;
    const std::uint32_t id = is_stuff ? kFirstStuffSegment + class_id : instance;
    Segment& segment = image.segments[id];
    segment.class_id = class_id;
    segment.add(i % columns, i / columns);
    image.ids[i] = {static_cast<std::uint8_t>(id), static_cast<std::uint8_t>(id >> 8),
                    static_cast<std::uint8_t>(id >> 16)};
    image.classes[i] = class_id;
  }
  return image;
}

Json segments_json(const PanopticImage& image) {
  Json segments = Json::array();
  for (const auto& [id, s] : image.segments) {
    segments.push_back({{"id", id},
                        {"category_id", s.class_id},
                        {"area", s.area},
                        {"bbox", {s.left, s.top, s.right - s.left + 1, s.bottom - s.top + 1}},
                        {"iscrowd", 0}});
  }
  return segments;
}

Status write_masks(const fs::path& annotations, const std::string& split, const std::string& name,
                   const PanopticImage& image, std::uint64_t rows, std::uint64_t columns) {
  const auto height = static_cast<int>(rows), width = static_cast<int>(columns);
  const auto ids = encode_png(image.ids, height, width);
  if (!ids) return ids.error();
  const auto classes = encode_png(image.classes, height, width);
  if (!classes) return classes.error();
  const Status written = write_whole(annotations / ("panoptic_" + split) / name, *ids);
  return written ? write_whole(annotations / ("semantic_" + split) / name, *classes) : written;
}

Status write_panoptic_ping(const ExportJob& job, const fs::path& target,
                           const StoredSequence& sequence, const StoredPing& ping,
                           PanopticFile& file) {
  const auto grey = path_of(job, sequence, ping, grey_of(job));
  if (!grey) return grey.error();
  const CatalogueRow& row = mask_of_view(job, "instance");
  const auto mask = path_of(job, sequence, ping, row);
  if (!mask) return mask.error();
  const NpyShape shape = grid_shape(row, sequence.sizes());
  const auto image = panoptic_image(job, sequence, *mask, shape[0], shape[1]);
  if (!image) return image.error();
  const std::string& split = sequence.row.split;
  const std::string file_name = item_name(job, sequence, ping) + grey->extension().string();
  const std::string png = item_name(job, sequence, ping) + ".png";
  const std::uint64_t id = file.images + 1;
  Json record = {{"id", id}, {"file_name", file_name}, {"width", shape[1]}, {"height", shape[0]}};
  record.update(run_members(job));
  file.add(record,
           {{"image_id", id}, {"file_name", png}, {"segments_info", segments_json(*image)}});
  const Status copied = copy_whole(*grey, target / "images" / split / file_name);
  if (!copied) return copied;
  return write_masks(target / "annotations", split, png, *image, shape[0], shape[1]);
}

}  // namespace

Status write_coco_panoptic(const ExportJob& job, const fs::path& target) {
  if (job.dataset.classes.size() >= kNoClass) {
    return Error{ErrorKind::usage,
                 fmt::format("{} classes, but 255 stands for no class in semantic masks; use "
                             "--format index_mask",
                             job.dataset.classes.size())};
  }
  const std::string opening = fmt::format("{{\n\"info\": {},\n\"categories\": {},\n\"images\": [",
                                          json_line({{"description", job.dataset.name}}),
                                          json_line(panoptic_categories(job)));
  PanopticFiles files;
  for (const std::string& split : splits_of(job)) {
    const fs::path annotations = target / "annotations";
    for (const fs::path& folder :
         {annotations / ("panoptic_" + split), annotations / ("semantic_" + split),
          target / "images" / split}) {
      std::error_code error;
      fs::create_directories(folder, error);
      if (error) return write_error(folder, error.value());
    }
    files.try_emplace(split, annotations / ("panoptic_" + split + ".json"), opening);
  }
  const Status written = for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    for (const CatalogueRow* row : {&grey_of(job), &mask_of_view(job, "instance")}) {
      if (const Status there = need(job, sequence, *row); !there) return there;
    }
    PanopticFile& file = files.at(sequence.row.split);
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return write_panoptic_ping(job, target, sequence, ping, file);
    });
  });
  if (!written) return written;
  for (auto& [split, file] : files) {
    if (const Status closed = file.close(); !closed) return closed;
  }
  return {};
}

}  // namespace ensonify
