#include "dataset/ping_record.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "dataset/catalogue.h"
#include "dataset/layout.h"
#include "dataset/mask.h"
#include "dataset/member_schema.h"
#include "formats/json.h"
#include "formats/sha256.h"

namespace ensonify {

static const char* name_of(ImageView view) { return view_name(view); }

namespace {

// The last line of a record: 64 digits and the line's end.
constexpr std::size_t kHashLine = 65;

// Further digits of a level are not significant and differ between processors.
double in_hundredths(double value) { return std::round(100 * value) / 100; }

// COCO's flat rings x, y, x, y, ... in pixels.
std::vector<std::vector<int>> polygons_of(const Annotation& annotation, int rows, int columns) {
  const auto runs = run_lengths(annotation.rle_counts, std::int64_t{rows} * columns);
  ENSONIFY_ASSERT(runs);
  std::vector<std::vector<int>> polygons;
  for (const std::vector<Corner>& ring : rings_of(mask_of(*runs, rows))) {
    std::vector<int>& flat = polygons.emplace_back();
    for (const Corner& corner : ring) {
      flat.push_back(corner.x);
      flat.push_back(corner.y);
    }
  }
  return polygons;
}

// An image in a line of annotations.jsonl. It has the file for training a detector or, for packed
// pings, its array and index, or none of them, if there are only masks.
struct AnnotatedImage {
  ImageView view = ImageView::polar;
  std::string file = {}, array = {};
  std::uint32_t index = 0;
  int width = 0, height = 0;
  bool polygons = false;
  std::span<const Annotation> annotations = {}, hidden = {};
};

struct AnnotatedPing {
  std::uint32_t ping = 0;
  double time_s = 0;
  std::span<const FiredGroup> groups = {};
  std::vector<AnnotatedImage> images = {};
};

template <class Io>
void amodal_members(Io& io, const Annotation& annotation) {
  const PixelMask mask = annotation.amodal.value_or(PixelMask{});
  io.null_if(!std::isfinite(annotation.occlusion), "occlusion", annotation.occlusion);
  io("amodal_bbox", mask.box);
  io("amodal_area", mask.area);
  io("amodal_counts", mask.rle_counts);
}

template <class Io>
void annotation_members(Io& io, const Annotation& annotation, const AnnotatedImage& image) {
  const double contrast_db = in_hundredths(annotation.measures.contrast_db);
  const double truncated = annotation.measures.truncated;
  io("instance", annotation.instance);
  io("bbox", annotation.box);
  io("area", annotation.area);
  io("counts", annotation.rle_counts);
  io.null_if(!std::isfinite(truncated), "truncated", truncated);
  io.null_if(!std::isfinite(contrast_db), "contrast_db", contrast_db);
  io.together_if(annotation.amodal.has_value(),
                 [&](Io& also) { amodal_members(also, annotation); });
  using Polygons = decltype(polygons_of(annotation, 0, 0));
  io.sometimes(
      image.polygons, "polygons",
      image.polygons ? polygons_of(annotation, image.height, image.width) : Polygons());
}

template <class Io>
void image_members(Io& io, const AnnotatedImage& image) {
  ImageView view = image.view;
  io.word("view", view, ImageView::cartesian);
  io.sometimes(!image.file.empty(), "file", image.file);
  io.together_if(!image.array.empty(), [&](Io& packed) {
    packed("array", image.array);
    packed("index", image.index);
  });
  io("width", image.width);
  io("height", image.height);
  io.list("annotations", image.annotations,
          [&](Io& item, auto& annotation) { annotation_members(item, annotation, image); });
  io.list("hidden", image.hidden, [](Io& item, auto& annotation) {
    item("instance", annotation.instance);
    amodal_members(item, annotation);
  });
}

// None without masks.
void add_image(const SequenceInfo& info, AnnotatedPing& ping, AnnotatedImage image,
               const std::optional<GreyImage>& grey, const std::optional<LabelledImage>& labelled) {
  const FileSelection selection = selection_of(info);
  const CatalogueRow* row = picture_row(image.view, selection);
  if (row == nullptr && !is_wanted(plane_row(image.view, "instance"), selection)) return;
  if (row != nullptr && info.output.packed) {
    image.array = row->array;
    image.index = ping.ping - info.first_ping;
  } else if (row != nullptr) {
    image.file = layout::ping_file(row->file, ping.ping);
  }
  image.height = grey ? grey->rows : labelled ? labelled->rows : 0;
  image.width = grey ? grey->columns : labelled ? labelled->columns : 0;
  image.polygons = info.output.polygons;
  ping.images.push_back(std::move(image));
}

template <class Io>
void ping_members(Io& io, const AnnotatedPing& ping) {
  io("ping", ping.ping);
  io("time_s", ping.time_s);
  io.list_if_any("groups", ping.groups, [](Io& item, auto& group) {
    item("time_s", group.time_s);
    item("level_db", group.level_db);
    item("position_m", group.sonar_in_world.position_m);
    item("quaternion_wxyz", group.sonar_in_world.rotation);
  });
  io.list("images", ping.images, [](Io& item, auto& image) { image_members(item, image); });
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

std::string annotation_line(const SequenceInfo& info, const PingResult& result) {
  AnnotatedPing ping{result.ping, result.time_s, result.groups, {}};
  add_image(info, ping,
            {.view = ImageView::polar,
             .annotations = result.polar_annotations,
             .hidden = result.polar_hidden},
            result.polar_grey, result.polar);
  add_image(info, ping,
            {.view = ImageView::cartesian,
             .annotations = result.cartesian_annotations,
             .hidden = result.cartesian_hidden},
            result.cartesian_grey, result.cartesian);
  Json line = Json::object();
  MemberWriter io(line);
  ping_members(io, ping);
  return json_line(line) + "\n";
}

}  // namespace

Json annotations_schema() {
  return MemberSchema::object_of([](MemberSchema& io) { ping_members(io, AnnotatedPing{}); });
}

PingRecord record_of(const SequenceInfo& info, const PingResult& result,
                     std::vector<FileEntry> files) {
  PingRecord record;
  record.ping = result.ping;
  record.time_s = result.time_s;
  record.sonar_in_world = result.sonar_in_world;
  record.object_in_world = result.object_in_world;
  record.first_return_m = result.first_return_m;
  record.grey_counts = result.grey_counts;
  record.annotations = annotation_line(info, result);
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
