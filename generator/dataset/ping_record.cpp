#include "dataset/ping_record.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "dataset/catalogue.h"
#include "dataset/coco.h"
#include "dataset/layout.h"
#include "dataset/mask.h"
#include "formats/json.h"
#include "formats/sha256.h"

namespace ensonify {
namespace {

// The last line of a record: 64 digits and the line's end.
constexpr std::size_t kHashLine = 65;

void add_amodal(Json& json, const Annotation& annotation) {
  if (!annotation.amodal) return;
  json["occlusion"] = number_or_null(annotation.occlusion);
  json["amodal_bbox"] = annotation.amodal->box;
  json["amodal_area"] = annotation.amodal->area;
  json["amodal_counts"] = annotation.amodal->rle_counts;
}

// Further digits of a level are not significant and differ between processors.
double in_hundredths(double value) { return std::round(100 * value) / 100; }

// COCO's flat rings x, y, x, y, ... in pixels.
Json polygons_json(const Annotation& annotation, int rows, int columns) {
  const auto runs = run_lengths(annotation.rle_counts, std::int64_t{rows} * columns);
  ENSONIFY_ASSERT(runs);
  Json polygons = Json::array();
  for (const std::vector<Corner>& ring : rings_of(mask_of(*runs, rows))) {
    Json flat = Json::array();
    for (const Corner& corner : ring) {
      flat.push_back(corner.x);
      flat.push_back(corner.y);
    }
    polygons.push_back(std::move(flat));
  }
  return polygons;
}

Json json_of(const Annotation& annotation) {
  Json json = {{"instance", annotation.instance},
               {"bbox", annotation.box},
               {"area", annotation.area},
               {"counts", annotation.rle_counts},
               {"truncated", number_or_null(annotation.measures.truncated)},
               {"contrast_db", number_or_null(in_hundredths(annotation.measures.contrast_db))}};
  add_amodal(json, annotation);
  return json;
}

// A fully hidden instance.
Json hidden_json(const Annotation& annotation) {
  Json json = {{"instance", annotation.instance}};
  add_amodal(json, annotation);
  return json;
}

// The file of the image for training a detector or, for packed pings, its array and index; empty if
// there are only masks, none without masks.
std::optional<Json> picture_of(const SequenceInfo& info, std::uint32_t ping, ImageView view) {
  const FileSelection selection = selection_of(info);
  const CatalogueRow* row = picture_row(view, selection);
  if (row == nullptr) {
    const bool has_masks = is_wanted(plane_row(view, "instance"), selection);
    return has_masks ? std::optional(Json::object()) : std::nullopt;
  }
  if (info.output.packed) {
    return Json::object({{"array", row->array}, {"index", ping - info.first_ping}});
  }
  return Json::object({{"file", layout::ping_file(row->file, ping)}});
}

void add_image(Json& images, const char* view, const std::optional<Json>& picture,
               std::pair<int, int> size, const std::vector<Annotation>& annotations,
               const std::vector<Annotation>& hidden, bool polygons) {
  if (!picture) return;
  Json list = Json::array();
  for (const Annotation& annotation : annotations) {
    list.push_back(json_of(annotation));
    if (polygons) list.back()["polygons"] = polygons_json(annotation, size.first, size.second);
  }
  Json hidden_list = Json::array();
  for (const Annotation& annotation : hidden) hidden_list.push_back(hidden_json(annotation));
  Json image = {{"view", view}};
  image.update(*picture);
  image["width"] = size.second;
  image["height"] = size.first;
  image["annotations"] = std::move(list);
  image["hidden"] = std::move(hidden_list);
  images.push_back(std::move(image));
}

std::pair<int, int> size_of(const std::optional<GreyImage>& grey,
                            const std::optional<LabelledImage>& labelled) {
  if (grey) return {grey->rows, grey->columns};
  if (labelled) return {labelled->rows, labelled->columns};
  return {0, 0};
}

std::optional<PingRecord> parse(const Json& json) {
  PingRecord record;
  const auto ping = count_at(json, "ping");
  const auto time = number_at(json, "time_s");
  const Json* sonar = member(json, "sonar_in_world");
  const Json* objects = member(json, "object_in_world");
  const Json* first = member(json, "first_return_m");
  const Json* grey = member(json, "grey");
  const Json* files = member(json, "files");
  if (!ping || !time || sonar == nullptr || objects == nullptr || first == nullptr ||
      files == nullptr || grey == nullptr) {
    return std::nullopt;
  }
  const auto count = [&](const char* key) { return count_at(*grey, key).value_or(0); };
  record.grey_counts = {count("all"), count("white"), count("echo"), count("black")};
  record.ping = static_cast<std::uint32_t>(*ping);
  record.time_s = *time;
  const auto pose = pose_of_json(*sonar);
  if (!pose) return std::nullopt;
  record.sonar_in_world = *pose;
  for (const Json& object : *objects) {
    const auto object_pose = pose_of_json(object);
    if (!object_pose) return std::nullopt;
    record.object_in_world.push_back(*object_pose);
  }
  for (const Json& range : *first) {
    record.first_return_m.push_back(range.is_number() ? static_cast<float>(range.get<double>())
                                                      : std::numeric_limits<float>::quiet_NaN());
  }
  for (const Json& file : *files) {
    const auto entry = file_entry_of(file);
    if (!entry) return std::nullopt;
    record.files.push_back(*entry);
  }
  return record;
}

}  // namespace

PingRecord record_of(const SequenceInfo& info, const PingResult& result,
                     std::vector<FileEntry> files) {
  PingRecord record;
  record.ping = result.ping;
  record.time_s = result.time_s;
  record.sonar_in_world = result.sonar_in_world;
  record.object_in_world = result.object_in_world;
  record.first_return_m = result.first_return_m;
  record.grey_counts = result.grey_counts;
  const bool polygons = info.output.polygons;
  Json images = Json::array();
  add_image(images, "polar", picture_of(info, result.ping, ImageView::polar),
            size_of(result.polar_grey, result.polar), result.polar_annotations, result.polar_hidden,
            polygons);
  add_image(images, "cartesian", picture_of(info, result.ping, ImageView::cartesian),
            size_of(result.cartesian_grey, result.cartesian), result.cartesian_annotations,
            result.cartesian_hidden, polygons);
  record.annotations = annotation_line(record.ping, record.time_s, std::move(images));
  record.files = std::move(files);
  return record;
}

std::string to_text(const PingRecord& record) {
  Json objects = Json::array();
  for (const Pose& pose : record.object_in_world) objects.push_back(json_of(pose));
  Json first = Json::array();
  for (const float range : record.first_return_m) first.push_back(number_or_null(range));
  Json files = Json::array();
  for (const FileEntry& entry : record.files) files.push_back(json_of(entry));
  const DisplayCounts& counts = record.grey_counts;
  const Json json = {{"ping", record.ping},
                     {"time_s", record.time_s},
                     {"sonar_in_world", json_of(record.sonar_in_world)},
                     {"object_in_world", std::move(objects)},
                     {"first_return_m", std::move(first)},
                     {"grey", Json::object({{"all", counts.all},
                                            {"white", counts.white},
                                            {"echo", counts.echo},
                                            {"black", counts.black}})},
                     {"files", std::move(files)}};
  const std::string lines = json_line(json) + "\n" + record.annotations;
  return lines + sha256_hex(lines) + "\n";
}

std::optional<PingRecord> parse_ping_record(std::string_view text) {
  const std::string_view lines = text.substr(0, text.size() - std::min(text.size(), kHashLine));
  const bool whole = text.substr(lines.size()) == sha256_hex(lines) + "\n";
  const std::size_t head = std::min(lines.find('\n'), lines.size());
  const auto json = whole ? parse_json(lines.substr(0, head)) : std::nullopt;
  auto record = json ? parse(*json) : std::nullopt;
  if (record) record->annotations = lines.substr(std::min(head + 1, lines.size()));
  return record;
}

Result<PingRecord> read_ping_record(const std::filesystem::path& dir, std::uint32_t sequence,
                                    std::uint32_t ping) {
  const auto path = dir / layout::record_path(sequence, ping);
  const auto text = read_file(path);
  if (!text) return text.error();
  auto record = parse_ping_record(*text);
  if (!record || record->ping != ping) {
    return Error{ErrorKind::damage, path.string() + ": not a record of this ping"};
  }
  return std::move(*record);
}

bool files_are_there(const std::filesystem::path& dir, std::uint32_t sequence,
                     const PingRecord& record) {
  return std::all_of(record.files.begin(), record.files.end(), [&](const FileEntry& entry) {
    return listed_file_size(dir, layout::in_sequence(sequence, entry.path)) == entry.bytes;
  });
}

}  // namespace ensonify
