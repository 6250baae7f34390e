#include "dataset/verify_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <optional>
#include <vector>

#include "dataset/mask.h"
#include "dataset/schema.h"
#include "formats/json.h"

namespace ensonify {
namespace {

struct Size {
  std::uint64_t rows = 0, columns = 0;
};

using Box = std::array<std::int64_t, 4>;

std::optional<Box> box_at(const Json& json, const char* key) {
  const Json* box = member(json, key);
  if (box == nullptr || !box->is_array() || box->size() != 4) return std::nullopt;
  Box numbers{};
  for (std::size_t i = 0; i < 4; ++i) {
    if (!(*box)[i].is_number_integer()) return std::nullopt;
    numbers[i] = (*box)[i].get<std::int64_t>();
  }
  return numbers;
}

// Whether area and box match the run lengths and are not empty.
bool is_whole(const Json& json, const char* area, const char* box,
              const std::optional<std::string>& counts, const Size& size) {
  if (!counts) return false;
  const auto extent = mask_extent(*counts, static_cast<std::int64_t>(size.rows),
                                  static_cast<std::int64_t>(size.columns));
  return extent && extent->area > 0 &&
         count_at(json, area) == static_cast<std::uint64_t>(extent->area) &&
         box_at(json, box) == extent->box;
}

bool holds(const Box& outer, const Box& inner) {
  return outer[0] <= inner[0] && outer[1] <= inner[1] &&
         outer[0] + outer[2] >= inner[0] + inner[2] && outer[1] + outer[3] >= inner[1] + inner[3];
}

// Null: no ray meets the instance.
bool is_share(const Json* value) {
  if (value == nullptr) return false;
  if (value->is_null()) return true;
  return value->is_number() && value->get<double>() >= 0 && value->get<double>() <= 1;
}

// Whether the amodal part of an annotation is complete; `counts` are its run lengths.
bool amodal_is_whole(const Json& json, const std::optional<std::string>& counts, const Size& size) {
  return is_share(member(json, "occlusion")) &&
         is_whole(json, "amodal_area", "amodal_bbox", counts, size);
}

bool amodal_holds_visible(const Json& json) {
  return count_at(json, "amodal_area") >= count_at(json, "area") &&
         holds(*box_at(json, "amodal_bbox"), *box_at(json, "bbox"));
}

// Twice the area of a ring of x, y, x, y, ..., positive clockwise with rows downwards; none if it
// is not such a ring.
std::optional<std::int64_t> twice_area(const Json& ring) {
  if (!ring.is_array() || ring.size() < 8 || ring.size() % 2 != 0) return std::nullopt;
  for (const Json& number : ring) {
    if (!number.is_number_integer()) return std::nullopt;
  }
  const std::size_t n = ring.size();
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < n; i += 2) {
    const Json &x = ring[i], &y = ring[i + 1], &xx = ring[(i + 2) % n], &yy = ring[(i + 3) % n];
    sum += x.get<std::int64_t>() * yy.get<std::int64_t>() -
           xx.get<std::int64_t>() * y.get<std::int64_t>();
  }
  return sum;
}

// Whether polygons, where there are any, enclose the annotation's area.
bool polygons_are_whole(const Json& json) {
  const Json* polygons = member(json, "polygons");
  if (polygons == nullptr) return true;
  if (!polygons->is_array()) return false;
  std::int64_t sum = 0;
  for (const Json& ring : *polygons) {
    const auto area = twice_area(ring);
    if (!area) return false;
    sum += *area;
  }
  return count_at(json, "area") == static_cast<std::uint64_t>(sum / 2);
}

bool line_annotation_is_whole(const Json& json, const Size& size) {
  if (!polygons_are_whole(json)) return false;
  if (!is_whole(json, "area", "bbox", text_at(json, "counts"), size)) return false;
  if (member(json, "amodal_counts") == nullptr) return true;
  return amodal_is_whole(json, text_at(json, "amodal_counts"), size) && amodal_holds_visible(json);
}

// Run lengths of coco.json, which names the size with them.
std::optional<std::string> counts_at(const Json& json, const char* key, const Size& size) {
  const Json* mask = member(json, key);
  if (mask == nullptr) return std::nullopt;
  const Json* said = member(*mask, "size");
  if (said == nullptr || *said != Json::array({size.rows, size.columns})) return std::nullopt;
  return text_at(*mask, "counts");
}

// Walks coco.json without keeping its images and annotations.
struct CocoReader {
  const std::set<std::string>& known;
  std::uint64_t classes;
  std::string array = {};  // the top-level member that is being read
  std::vector<Size> images = {};
  std::uint64_t annotations = 0, hidden = 0;
  std::string fault = {};  // the first one
  const SchemaCheck image_schema{"coco", "image"}, annotation_schema{"coco", "annotation"},
      hidden_schema{"coco", "hidden"};

  void image(const Json& image) {
    // Packed pings have an array and an index instead of a file name.
    const auto file = text_at(image, member(image, "array") != nullptr ? "array" : "file_name");
    const auto rows = count_at(image, "height"), columns = count_at(image, "width");
    images.push_back({rows.value_or(0), columns.value_or(0)});
    if (count_at(image, "id") != images.size()) {
      fault = fmt::format("image {} has no id or a wrong id", images.size());
    } else if (!file || !known.contains(*file)) {
      fault = fmt::format("image {} refers to a file that is not in the data set", images.size());
    }
  }

  // Whether there is no fault so far and this element matches its schema.
  bool fits(const SchemaCheck& schema, std::size_t index, const Json& element) {
    if (fault.empty()) fault = schema.fault(element, fmt::format("/{}/{}", array, index));
    return fault.empty();
  }

  // The size of its image; none if the image or class does not exist.
  std::optional<Size> size_of(const Json& annotation) const {
    const auto category = count_at(annotation, "category_id").value_or(0);
    const auto image_id = count_at(annotation, "image_id").value_or(0);
    if (image_id < 1 || image_id > images.size() || category < 1 || category > classes) {
      return std::nullopt;
    }
    return images[image_id - 1];
  }

  bool visible_is_whole(const Json& annotation) const {
    const auto size = size_of(annotation);
    if (!size || count_at(annotation, "id") != annotations || !polygons_are_whole(annotation) ||
        !is_whole(annotation, "area", "bbox", counts_at(annotation, "segmentation", *size),
                  *size)) {
      return false;
    }
    return member(annotation, "amodal_segmentation") == nullptr ||
           (hidden_is_whole(annotation) && amodal_holds_visible(annotation));
  }

  bool hidden_is_whole(const Json& annotation) const {
    const auto size = size_of(annotation);
    return size &&
           amodal_is_whole(annotation, counts_at(annotation, "amodal_segmentation", *size), *size);
  }

  bool operator()(int depth, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::key && depth == 1) array = parsed.get<std::string>();
    if (event != Json::parse_event_t::object_end || depth != 2) return true;
    if (array == "images") {
      if (fits(image_schema, images.size(), parsed)) image(parsed);
    } else if (array == "annotations") {
      const bool fitting = fits(annotation_schema, annotations++, parsed);
      if (fitting && !visible_is_whole(parsed)) {
        fault = fmt::format("annotation {} is inconsistent", annotations);
      }
    } else if (array == "hidden") {
      const bool fitting = fits(hidden_schema, hidden++, parsed);
      if (fitting && !hidden_is_whole(parsed)) {
        fault = fmt::format("entry {} of `hidden` is inconsistent", hidden);
      }
    } else {
      return true;
    }
    return false;
  }
};

}  // namespace

std::string line_masks_fault(const Json& line) {
  for (const Json& image : line.at("images")) {
    const Size size{count_at(image, "height").value_or(0), count_at(image, "width").value_or(0)};
    const Json* annotations = member(image, "annotations");
    const Json* hidden = member(image, "hidden");
    const bool whole =
        annotations != nullptr && hidden != nullptr &&
        std::all_of(annotations->begin(), annotations->end(),
                    [&](const Json& a) { return line_annotation_is_whole(a, size); }) &&
        std::all_of(hidden->begin(), hidden->end(), [&](const Json& a) {
          return amodal_is_whole(a, text_at(a, "amodal_counts"), size);
        });
    if (!whole) {
      return fmt::format(
          "a mask of ping {} is inconsistent: its area or box differ from those of its "
          "run lengths",
          count_at(line, "ping").value_or(0));
    }
  }
  return {};
}

std::string coco_fault(const std::filesystem::path& path, const std::set<std::string>& known,
                       std::uint64_t classes) {
  CocoReader reader{known, classes};
  std::ifstream file(path, std::ios::binary);
  const Json json = parse_shallow_with(std::ref(reader), file);
  if (json.is_discarded()) return "is not JSON";
  const std::string fault = SchemaCheck("coco").fault(json);
  return fault.empty() ? reader.fault : fault;
}

}  // namespace ensonify
