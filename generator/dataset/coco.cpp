#include "dataset/coco.h"

#include <fmt/format.h>

#include <fstream>

#include "dataset/layout.h"
#include "dataset/manifest_json.h"

namespace ensonify {
namespace {

// The elements of a JSON array, one a line. Without a file they are only counted.
class ElementWriter {
 public:
  explicit ElementWriter(StreamedFile* file) : file_(file) {}
  void add(const Json& element) {
    const std::string text = (bytes_ == 0 ? "\n  " : ",\n  ") + json_line(element);
    if (file_ != nullptr) file_->append(text);
    bytes_ += text.size();
  }
  std::uint64_t bytes() const { return bytes_; }

 private:
  StreamedFile* file_;
  std::uint64_t bytes_ = 0;
};

Json image_json(std::uint64_t id, const SequenceInfo& info, const Json& line, const Json& image) {
  const auto full = [&](const Json& name) {
    return layout::in_sequence(info.sequence, name.get<std::string>());
  };
  Json json = {{"id", id}};
  if (const Json* file = member(image, "file")) {
    json["file_name"] = full(*file);
  } else {
    json["array"] = full(image.at("array"));
    json["index"] = image.at("index");
  }
  json.update({{"width", image.at("width")},
               {"height", image.at("height")},
               {"view", image.at("view")},
               {"sequence", info.sequence},
               {"ping", line.at("ping")},
               {"split", info.split}});
  return json;
}

// Of masks without an image there is nothing that a detector could be trained on.
bool has_image(const Json& image) { return image.contains("file") || image.contains("array"); }

Json mask_json(const Json& image, const Json& counts) {
  return {{"size", Json::array({image.at("height"), image.at("width")})}, {"counts", counts}};
}

void add_amodal(Json& json, const Json& image, const Json& annotation) {
  if (!annotation.contains("amodal_counts")) return;
  json["occlusion"] = annotation.at("occlusion");
  json["amodal_bbox"] = annotation.at("amodal_bbox");
  json["amodal_area"] = annotation.at("amodal_area");
  json["amodal_segmentation"] = mask_json(image, annotation.at("amodal_counts"));
}

Json annotation_json(std::uint64_t id, std::uint64_t image_id, const Instance& instance,
                     const Json& image, const Json& annotation) {
  Json json = {{"id", id},
               {"image_id", image_id},
               {"category_id", instance.class_id},
               {"bbox", annotation.at("bbox")},
               {"area", annotation.at("area")},
               {"iscrowd", 0},
               {"segmentation", mask_json(image, annotation.at("counts"))},
               {"instance_id", instance.id},
               {"name", instance.name}};
  if (annotation.contains("polygons")) json["polygons"] = annotation.at("polygons");
  add_amodal(json, image, annotation);
  return json;
}

Json hidden_json(std::uint64_t image_id, const Instance& instance, const Json& image,
                 const Json& annotation) {
  Json json = {{"image_id", image_id},
               {"category_id", instance.class_id},
               {"instance_id", instance.id},
               {"name", instance.name}};
  add_amodal(json, image, annotation);
  return json;
}

Json categories_json(const std::vector<std::string>& classes) {
  Json categories = Json::array();
  for (std::size_t k = 0; k < classes.size(); ++k) {
    categories.push_back({{"id", k + 1}, {"name", classes[k]}, {"supercategory", "object"}});
  }
  return categories;
}

const Instance* find_instance(const SequenceInfo& info, const Json& annotation) {
  const auto id = annotation.at("instance").get<std::uint64_t>();
  return id >= 1 && id <= info.instances.size() ? &info.instances[id - 1] : nullptr;
}

// The lists of coco.json, which grow side by side: a line of annotations.jsonl is parsed once.
struct Lists {
  ElementWriter images, annotations, hidden;
  std::uint64_t image_id = 0, annotation_id = 0;
};

Status add_image(const SequenceInfo& info, const Json& line, const Json& image, Lists& lists) {
  const std::uint64_t image_id = ++lists.image_id;
  lists.images.add(image_json(image_id, info, line, image));
  const auto add = [&](const char* key, const auto& use) -> Status {
    for (const Json& annotation : image.at(key)) {
      const Instance* instance = find_instance(info, annotation);
      if (instance == nullptr) {
        return Error{ErrorKind::bug, fmt::format("sequence {}: an annotation of an instance that "
                                                 "the sequence does not have",
                                                 info.sequence)};
      }
      use(*instance, annotation);
    }
    return {};
  };
  Status added = add("annotations", [&](const Instance& instance, const Json& annotation) {
    lists.annotations.add(
        annotation_json(++lists.annotation_id, image_id, instance, image, annotation));
  });
  if (!added) return added;
  return add("hidden", [&](const Instance& instance, const Json& annotation) {
    lists.hidden.add(hidden_json(image_id, instance, image, annotation));
  });
}

Status add_line(const SequenceInfo& info, const Json& line, Lists& lists) {
  for (const Json& image : line.at("images")) {
    if (!has_image(image)) continue;
    if (Status added = add_image(info, line, image, lists); !added) return added;
  }
  return {};
}

Status add_sequence(const std::filesystem::path& dir, const SequenceInfo& info, Lists& lists) {
  return for_each_annotation_line(dir, info.sequence,
                                  [&](const Json& line) { return add_line(info, line, lists); });
}

}  // namespace

std::string annotation_line(std::uint32_t ping, double time_s, Json images) {
  Json line = {{"ping", ping}, {"time_s", time_s}};
  line["images"] = std::move(images);
  return json_line(line) + "\n";
}

Status for_each_annotation_line(const std::filesystem::path& dir, std::uint32_t sequence,
                                const std::function<Status(const Json&)>& use) {
  const auto path = dir / layout::in_sequence(sequence, layout::kAnnotations);
  std::ifstream file(path, std::ios::binary);
  std::string line;
  while (std::getline(file, line)) {
    const auto json = parse_json(line);
    if (!json || !count_at(*json, "ping") || !number_at(*json, "time_s") ||
        member(*json, "images") == nullptr) {
      return Error{ErrorKind::damage, path.string() + ": a line is not one of ensonify's"};
    }
    if (const Status used = use(*json); !used) return used;
  }
  if (!file.eof()) {
    return Error{ErrorKind::io, "cannot read " + path.string()};
  }
  return {};
}

Result<FileEntry> write_coco(const std::filesystem::path& dir, const std::string& name,
                             const std::vector<std::uint32_t>& sequences,
                             const std::vector<std::string>& classes) {
  StreamedFile file(dir, "coco.json");
  StreamedFile annotations(dir, "coco.json.annotations", false);
  StreamedFile hidden(dir, "coco.json.hidden", false);
  const Json info = {{"description", name + ": multibeam sonar pictures by ensonify"}};
  file.append("{\n\"info\": " + json_line(info) + ",\n\"licenses\": [],\n\"categories\": " +
              json_line(categories_json(classes)) + ",\n\"images\": [");
  Lists lists{ElementWriter(&file), ElementWriter(&annotations), ElementWriter(&hidden)};
  for (const std::uint32_t sequence : sequences) {
    const auto manifest = read_sequence_manifest(dir, sequence);
    if (!manifest) {
      return damaged(dir / layout::in_sequence(sequence, layout::kSequenceJson), "cannot be read");
    }
    const Status added = add_sequence(dir, manifest->info, lists);
    if (!added) return added.error();
  }
  file.append("\n],\n\"annotations\": [");
  file.append_all_of(annotations);
  file.append("\n],\n\"hidden\": [");
  file.append_all_of(hidden);
  file.append("\n]\n}\n");
  return file.commit();
}

Result<std::uint64_t> coco_bytes(const SequenceInfo& info, const Json& line) {
  Lists lists{ElementWriter(nullptr), ElementWriter(nullptr), ElementWriter(nullptr)};
  if (const Status added = add_line(info, line, lists); !added) return added.error();
  return lists.images.bytes() + lists.annotations.bytes() + lists.hidden.bytes();
}

}  // namespace ensonify
