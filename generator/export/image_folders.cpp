// Images and labels in folders:
//
//   yolo        Ultralytics: images/SPLIT/*.png, labels/SPLIT/*.txt, data.yaml. A label line is
//               `class x y x y ...` (an outline) or `class x y width height` (a box and its
//               center), in parts of the image's width and height; classes count from 0.
//   voc         Annotations/*.xml, JPEGImages/*.png, ImageSets/{Main,Segmentation}/SPLIT.txt, and
//               SegmentationClass and SegmentationObject as indexed PNG in PASCAL VOC's colors.
//               Boxes are VOC's: the first pixel is 1, and the last one belongs to the box.
//   index_mask  SPLIT/images, SPLIT/masks (class ids, 8 bits) and SPLIT/instances (16 bits), with
//               the same names, and classes.txt, whose line k + 1 is class id k.
// Images of a JPEG render end with .jpg.
#include <fmt/format.h>

#include <array>
#include <map>
#include <memory>
#include <utility>

#include "dataset/layout.h"
#include "dataset/mask.h"
#include "export/job.h"
#include "formats/files.h"
#include "formats/json.h"
#include "formats/output_place.h"
#include "formats/png.h"

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
  const auto grey = path_of(job, sequence, ping, grey_of(job));
  if (!grey) return grey.error();
  const auto picture = picture_of_view(job, sequence, ping, job.view());
  if (!picture) return picture.error();
  std::string labels;
  for (const StoredAnnotation& annotation : picture->annotations) {
    const Mask mask = mask_of(annotation.runs, static_cast<std::int64_t>(picture->height));
    labels += label_line(job, *picture, mask, sequence.instances[annotation.instance - 1].class_id);
  }
  const std::string name = item_name(job, sequence, ping);
  const std::string image = name + grey->extension().string();
  const Status copied = copy_whole(*grey, target / "images" / sequence.row.split / image);
  if (!copied) return copied;
  return write_whole(target / "labels" / sequence.row.split / (name + ".txt"), labels);
}

Status write_data_yaml(const ExportJob& job, const fs::path& target) {
  std::string text = "# Paths are relative to this file.\n";
  for (const char* split : layout::kSplits) {
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
    if (const Status there = need(job, sequence, grey_of(job)); !there) return there;
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return write_yolo_ping(job, target, sequence, ping);
    });
  });
}

namespace {

// 255 marks unlabeled pixels.
constexpr std::size_t kMostIndices = 254;

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

struct LabelPicture {
  std::uint64_t rows, columns;
  std::vector<std::uint8_t> classes, objects;
  std::string xml;  // of the objects
};

void add_object(LabelPicture& label, const Mask& mask, std::uint8_t class_id, std::uint8_t index,
                const std::string& class_name) {
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      const auto in_mask = static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width) +
                           static_cast<std::size_t>(x);
      if (mask.pixels[in_mask] == 0) continue;
      const std::size_t pixel = static_cast<std::size_t>(mask.top + y) * label.columns +
                                static_cast<std::size_t>(mask.left + x);
      label.classes[pixel] = class_id;
      label.objects[pixel] = index;
    }
  }
  const int right = mask.left + mask.width, bottom = mask.top + mask.height;
  const bool cut = mask.left == 0 || mask.top == 0 || std::cmp_equal(right, label.columns) ||
                   std::cmp_equal(bottom, label.rows);
  label.xml += fmt::format(
      "  <object>\n    <name>{}</name>\n    <pose>Unspecified</pose>\n"
      "    <truncated>{}</truncated>\n    <difficult>0</difficult>\n    <bndbox>"
      "<xmin>{}</xmin><ymin>{}</ymin><xmax>{}</xmax><ymax>{}</ymax></bndbox>\n  </object>\n",
      escaped(class_name), cut ? 1 : 0, mask.left + 1, mask.top + 1, right, bottom);
}

Result<LabelPicture> label_picture(const ExportJob& job, const StoredSequence& sequence,
                                   const StoredPing& ping) {
  const auto picture = picture_of_view(job, sequence, ping, job.view());
  if (!picture) return picture.error();
  const std::size_t pixels = picture->width * picture->height;
  LabelPicture label{picture->height, picture->width, std::vector<std::uint8_t>(pixels),
                     std::vector<std::uint8_t>(pixels), ""};
  if (picture->annotations.size() > kMostIndices) {
    return Error{
        ErrorKind::usage,
        fmt::format("sequence {}, ping {}: {} instances in an image, but VOC has indices for only "
                    "{}; use --format index_mask",
                    sequence.row.sequence, ping.ping, picture->annotations.size(), kMostIndices)};
  }
  std::uint8_t index = 0;
  for (const StoredAnnotation& annotation : picture->annotations) {
    const Mask mask = mask_of(annotation.runs, static_cast<std::int64_t>(picture->height));
    const std::uint8_t class_id = sequence.instances[annotation.instance - 1].class_id;
    add_object(label, mask, class_id, ++index, job.dataset.classes[class_id - 1U]);
  }
  return label;
}

Status write_voc_ping(const ExportJob& job, const fs::path& target, const StoredSequence& sequence,
                      const StoredPing& ping) {
  const Palette palette = voc_palette();
  const std::string name = item_name(job, sequence, ping);
  const auto grey = path_of(job, sequence, ping, grey_of(job));
  if (!grey) return grey.error();
  const auto label = label_picture(job, sequence, ping);
  if (!label) return label.error();
  const std::string image = name + grey->extension().string();
  const std::string xml = fmt::format(
      "<annotation>\n  <folder>JPEGImages</folder>\n  <filename>{}</filename>\n"
      "  <source><database>{}</database></source>\n"
      "  <size><width>{}</width><height>{}</height><depth>{}</depth></size>\n"
      "  <segmented>1</segmented>\n{}</annotation>\n",
      image, escaped(job.dataset.name), label->columns, label->rows,
      job.render && !job.render->display.color_map.empty() ? 3 : 1, label->xml);
  Status done = copy_whole(*grey, target / "JPEGImages" / image);
  if (done) done = write_whole(target / "Annotations" / (name + ".xml"), xml);
  const std::pair<const char*, const std::vector<std::uint8_t>*> masks[] = {
      {"SegmentationClass", &label->classes}, {"SegmentationObject", &label->objects}};
  for (const auto& [folder, indices] : masks) {
    if (!done) return done;
    const auto png = encode_palette_png(*indices, static_cast<int>(label->rows),
                                        static_cast<int>(label->columns), palette);
    done = png ? write_whole(target / folder / (name + ".png"), *png) : Status(png.error());
  }
  return done;
}

// The same lists for boxes and for masks: every image has both.
class ImageSets {
 public:
  explicit ImageSets(const fs::path& target) {
    for (const char* kind : {"Main", "Segmentation"}) {
      for (const char* split : layout::kSplits) {
        files_[split].push_back(std::make_unique<StreamedFile>(target / "ImageSets" / kind /
                                                               (std::string(split) + ".txt")));
      }
    }
  }
  void add(const std::string& split, const std::string& name) {
    for (auto& file : files_[split]) file->append(name + "\n");
  }
  Status close() {
    for (auto& [split, files] : files_) {
      for (auto& file : files) {
        if (const Status closed = file->close(); !closed) return closed;
      }
    }
    return {};
  }

 private:
  std::map<std::string, std::vector<std::unique_ptr<StreamedFile>>> files_;
};

}  // namespace

Status write_voc(const ExportJob& job, const fs::path& target) {
  if (job.dataset.classes.size() > kMostIndices) {
    return Error{ErrorKind::usage,
                 fmt::format("{} classes, but VOC has indices for only {}; use --format index_mask",
                             job.dataset.classes.size(), kMostIndices)};
  }
  ImageSets sets(target);
  const Status written = for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    if (const Status there = need(job, sequence, grey_of(job)); !there) return there;
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      sets.add(sequence.row.split, item_name(job, sequence, ping));
      return write_voc_ping(job, target, sequence, ping);
    });
  });
  return written ? sets.close() : written;
}

namespace {

std::array<std::pair<const char*, const CatalogueRow*>, 3> copies_of(const ExportJob& job) {
  return {{{"images", &grey_of(job)},
           {"masks", &mask_of_view(job, "semantic")},
           {"instances", &mask_of_view(job, "instance")}}};
}

Status copy_ping(const ExportJob& job, const fs::path& target, const StoredSequence& sequence,
                 const StoredPing& ping) {
  for (const auto& [folder, row] : copies_of(job)) {
    const auto from = path_of(job, sequence, ping, *row);
    if (!from) return from.error();
    const std::string name = item_name(job, sequence, ping) + from->extension().string();
    const fs::path to = target / sequence.row.split / folder / name;
    if (const Status copied = copy_whole(*from, to); !copied) return copied;
  }
  return {};
}

}  // namespace

Status write_index_mask(const ExportJob& job, const fs::path& target) {
  std::string names = "none\n";
  for (const std::string& name : job.dataset.classes) names += name + "\n";
  if (const Status written = write_whole(target / "classes.txt", names); !written) return written;
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    for (const auto& [folder, row] : copies_of(job)) {
      if (const Status there = need(job, sequence, *row); !there) return there;
    }
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return copy_ping(job, target, sequence, ping);
    });
  });
}

}  // namespace ensonify
