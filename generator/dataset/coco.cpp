#include "dataset/coco.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <type_traits>

#include "dataset/layout.h"
#include "dataset/manifest_json.h"
#include "formats/json.h"

namespace ensonify {

// Writes the elements of a JSON array, one per line. Without a file they are only counted.
class CocoElements {
 public:
  explicit CocoElements(StreamedFile* file) : file_(file) {}
  void add(const std::string& element) {
    const std::string_view start = bytes_ == 0 ? "\n  " : ",\n  ";
    if (file_ != nullptr) {
      file_->append(start);
      file_->append(element);
    }
    bytes_ += start.size() + element.size();
  }
  std::uint64_t bytes() const { return bytes_; }

 private:
  StreamedFile* file_;
  std::uint64_t bytes_ = 0;
};

// The lists of coco.json, which grow at the same time.
struct CocoLists {
  CocoElements images, annotations, hidden;
  std::uint64_t image_id = 0, annotation_id = 0;
};

namespace {

// Thrown where a line lacks a member.
struct IncompleteLine {};

std::string_view text_of(const JsonMembers& members, std::string_view key) {
  const std::string_view text = members.at(key);
  if (text.empty()) throw IncompleteLine();
  return text;
}

template <class Value>
Value value_of(const JsonMembers& members, std::string_view key) {
  const auto json = parse_json(text_of(members, key));
  const bool fits = json && (std::is_arithmetic_v<Value> ? json->is_number() : json->is_string());
  if (!fits) throw IncompleteLine();
  return json->get<Value>();
}

std::string image_json(std::uint64_t id, const SequenceInfo& info, std::string_view ping,
                       const JsonMembers& image, const CocoImage* chosen) {
  const auto full = [&](std::string_view key) {
    return quoted_text(layout::in_sequence(info.sequence, value_of<std::string>(image, key)));
  };
  const auto array = [&] {
    return fmt::format(R"("array":{},"index":{})", full("array"), text_of(image, "index"));
  };
  const std::string place =
      chosen == nullptr && image.at("file").empty()
          ? array()
          : fmt::format(R"("file_name":{})",
                        chosen != nullptr ? quoted_text(chosen->file_name) : full("file"));
  return fmt::format(
      R"({{"id":{},{},"width":{},"height":{},"view":{},"sequence":{},"ping":{},"split":{}{}}})", id,
      place, text_of(image, "width"), text_of(image, "height"), text_of(image, "view"),
      info.sequence, ping, quoted_text(info.split), chosen != nullptr ? chosen->more : "");
}

// Masks without an image cannot train a detector.
bool has_image(const JsonMembers& image) {
  return !image.at("file").empty() || !image.at("array").empty();
}

std::string mask_json(const JsonMembers& image, std::string_view counts) {
  return fmt::format(R"({{"size":[{},{}],"counts":{}}})", text_of(image, "height"),
                     text_of(image, "width"), counts);
}

// The members of an amodal mask, each after a comma; empty without a mask.
std::string amodal_json(const JsonMembers& image, const JsonMembers& annotation) {
  if (annotation.at("amodal_counts").empty()) return {};
  return fmt::format(
      R"(,"occlusion":{},"amodal_bbox":{},"amodal_area":{},"amodal_segmentation":{})",
      text_of(annotation, "occlusion"), text_of(annotation, "amodal_bbox"),
      text_of(annotation, "amodal_area"), mask_json(image, annotation.at("amodal_counts")));
}

std::string annotation_json(std::uint64_t id, std::uint64_t image_id, const Instance& instance,
                            const JsonMembers& image, const JsonMembers& annotation) {
  const std::string_view polygons = annotation.at("polygons");
  return fmt::format(
      R"({{"id":{},"image_id":{},"category_id":{},"bbox":{},"area":{},"iscrowd":0,)"
      R"("segmentation":{},"instance_id":{},"name":{},"truncated":{},"contrast_db":{}{}{}{}}})",
      id, image_id, instance.class_id, text_of(annotation, "bbox"), text_of(annotation, "area"),
      mask_json(image, text_of(annotation, "counts")), instance.id, quoted_text(instance.name),
      text_of(annotation, "truncated"), text_of(annotation, "contrast_db"),
      polygons.empty() ? "" : R"(,"polygons":)", polygons, amodal_json(image, annotation));
}

std::string hidden_json(std::uint64_t image_id, const Instance& instance, const JsonMembers& image,
                        const JsonMembers& annotation) {
  return fmt::format(R"({{"image_id":{},"category_id":{},"instance_id":{},"name":{}{}}})", image_id,
                     instance.class_id, instance.id, quoted_text(instance.name),
                     amodal_json(image, annotation));
}

const Instance* find_instance(const SequenceInfo& info, const JsonMembers& annotation) {
  const auto id = value_of<std::uint64_t>(annotation, "instance");
  return id >= 1 && id <= info.instances.size() ? &info.instances[id - 1] : nullptr;
}

// Calls use(members) for the objects in the list of that key. Error of `use`.
template <class Use>
Status for_each_object(const JsonMembers& parent, std::string_view key, const Use& use) {
  const auto list = json_elements(text_of(parent, key));
  if (!list) throw IncompleteLine();
  for (const std::string_view text : *list) {
    const auto object = json_members(text);
    if (!object) throw IncompleteLine();
    if (Status used = use(*object); !used) return used;
  }
  return {};
}

bool holds(const std::vector<std::uint16_t>& instances, std::uint32_t id) {
  return std::find(instances.begin(), instances.end(), id) != instances.end();
}

Status add_image(const SequenceInfo& info, std::string_view ping, const JsonMembers& image,
                 CocoLists& lists, const CocoImage* chosen = nullptr) {
  const std::uint64_t image_id = ++lists.image_id;
  lists.images.add(image_json(image_id, info, ping, image, chosen));
  const auto add = [&](std::string_view key, const auto& use) {
    return for_each_object(image, key, [&](const JsonMembers& annotation) -> Status {
      const Instance* instance = find_instance(info, annotation);
      if (instance == nullptr) {
        return Error{ErrorKind::bug,
                     fmt::format("sequence {}: an annotation refers to an instance that "
                                 "the sequence does not have",
                                 info.sequence)};
      }
      use(*instance, annotation);
      return {};
    });
  };
  Status added = add("annotations", [&](const Instance& instance, const JsonMembers& annotation) {
    if (chosen != nullptr && !holds(chosen->instances, instance.id)) return;
    lists.annotations.add(
        annotation_json(++lists.annotation_id, image_id, instance, image, annotation));
  });
  if (!added || chosen != nullptr) return added;
  return add("hidden", [&](const Instance& instance, const JsonMembers& annotation) {
    lists.hidden.add(hidden_json(image_id, instance, image, annotation));
  });
}

// Throws IncompleteLine.
Status add_line(const SequenceInfo& info, std::string_view text, CocoLists& lists) {
  const auto line = json_members(text);
  if (!line) throw IncompleteLine();
  return for_each_object(*line, "images", [&](const JsonMembers& image) {
    return has_image(image) ? add_image(info, text_of(*line, "ping"), image, lists) : Status();
  });
}

// Calls use(text) for the lines of a sequence's annotations.jsonl, which may throw IncompleteLine.
Status for_each_line(const std::filesystem::path& dir, std::uint32_t sequence,
                     const std::function<Status(std::string_view)>& use) {
  const auto path = dir / layout::in_sequence(sequence, layout::kAnnotations);
  std::ifstream file(path, std::ios::binary);
  std::string line;
  try {
    while (std::getline(file, line)) {
      if (const Status used = use(line); !used) return used;
    }
  } catch (const IncompleteLine&) {
    return Error{ErrorKind::damage, path.string() + ": a line was not written by ensonify"};
  }
  if (!file.eof()) {
    return Error{ErrorKind::io, "cannot read " + path.string()};
  }
  return {};
}

std::string head_text(const std::string& name, const Json& categories, bool recorded = false) {
  const Json info = {
      {"description",
       name + (recorded ? ": recorded multibeam sonar images without labels, imported by ensonify"
                        : ": simulated multibeam sonar images, generated by ensonify")}};
  return "{\n\"info\": " + json_line(info) +
         ",\n\"licenses\": [],\n\"categories\": " + json_line(categories) + ",\n\"images\": [";
}

}  // namespace

Json categories_json(const std::vector<std::string>& classes, const std::vector<ClassKind>& kinds) {
  Json categories = Json::array();
  for (std::size_t k = 0; k < classes.size(); ++k) {
    categories.push_back({{"id", k + 1},
                          {"name", classes[k]},
                          {"supercategory", "object"},
                          {"isthing", kinds[k] == ClassKind::thing ? 1 : 0}});
  }
  return categories;
}

struct CocoFile::State {
  StreamedFile file, annotations;
  CocoLists lists{CocoElements(&file), CocoElements(&annotations), CocoElements(nullptr)};
};

CocoFile::CocoFile(const std::filesystem::path& path, const std::string& name,
                   const Json& categories)
    : state_(new State{StreamedFile(path), StreamedFile(path.string() + ".annotations")}) {
  state_->file.append(head_text(name, categories));
}
CocoFile::~CocoFile() = default;

Status CocoFile::add(const SequenceInfo& info, std::string_view line, const CocoImage& image) {
  try {
    const auto members = json_members(line);
    if (!members) throw IncompleteLine();
    return for_each_object(*members, "images", [&](const JsonMembers& of) {
      const bool is_chosen = value_of<std::string>(of, "view") == image.view;
      return is_chosen ? add_image(info, text_of(*members, "ping"), of, state_->lists, &image)
                       : Status();
    });
  } catch (const IncompleteLine&) {
    return Error{ErrorKind::damage,
                 fmt::format("sequence {}: a line of annotations lacks a member", info.sequence)};
  }
}

Status CocoFile::close() {
  state_->file.append("\n],\n\"annotations\": [");
  state_->file.append_all_of(state_->annotations);
  state_->file.append("\n]\n}\n");
  return state_->file.close();
}

Status for_each_annotated_ping(const std::filesystem::path& dir, std::uint32_t sequence,
                               const std::function<void(std::uint32_t, double)>& use) {
  return for_each_line(dir, sequence, [&](std::string_view text) {
    const auto line = json_members(text);
    if (!line) throw IncompleteLine();
    use(value_of<std::uint32_t>(*line, "ping"), value_of<double>(*line, "time_s"));
    return Status();
  });
}

Result<FileEntry> write_coco(const std::filesystem::path& dir, const std::string& name,
                             const std::vector<std::uint32_t>& sequences, const Json& categories,
                             bool recorded) {
  StreamedFile file(dir, "coco.json");
  StreamedFile annotations(dir, "coco.json.annotations", false);
  StreamedFile hidden(dir, "coco.json.hidden", false);
  file.append(head_text(name, categories, recorded));
  CocoLists lists{CocoElements(&file), CocoElements(&annotations), CocoElements(&hidden)};
  for (const std::uint32_t sequence : sequences) {
    const auto manifest = read_sequence_manifest(dir, sequence);
    if (!manifest) {
      return damaged(dir / layout::in_sequence(sequence, layout::kSequenceJson), "cannot be read");
    }
    const Status added = for_each_line(dir, sequence, [&](std::string_view line) {
      return add_line(manifest->info, line, lists);
    });
    if (!added) return added.error();
  }
  file.append("\n],\n\"annotations\": [");
  file.append_all_of(annotations);
  file.append("\n],\n\"hidden\": [");
  file.append_all_of(hidden);
  file.append("\n]\n}\n");
  return file.commit();
}

Result<std::uint64_t> coco_bytes(const SequenceInfo& info, std::string_view line) {
  CocoLists lists{CocoElements(nullptr), CocoElements(nullptr), CocoElements(nullptr)};
  try {
    if (const Status added = add_line(info, line, lists); !added) return added.error();
  } catch (const IncompleteLine&) {
    return Error{ErrorKind::bug, "a line of annotations lacks a member"};
  }
  return lists.images.bytes() + lists.annotations.bytes() + lists.hidden.bytes();
}

}  // namespace ensonify
