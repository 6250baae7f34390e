#include "dataset/read_dataset.h"

#include <fmt/format.h>

#include <algorithm>

#include "dataset/json.h"
#include "dataset/layout.h"
#include "dataset/rle.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kSplits[] = {"train", "val", "test"};

// What is larger is taken for damage before memory is asked for.
constexpr std::uint64_t kMaxSide = 1'000'000;
constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 31;

Error usage(const fs::path& dir, const std::string& what) {
  return {ErrorKind::usage, dir.string() + ": " + what};
}

Result<std::string> text_of(const fs::path& dir, const std::string& relative) {
  if (!listed_file_size(dir, relative)) {
    return damaged(dir / relative, "is missing, or is no file of this folder");
  }
  return read_file(dir / relative);
}

// A manifest whose list of files stays inside the folder.
Result<Json> manifest_of(const fs::path& path, std::string_view text) {
  std::optional<std::string> outside;
  const auto json = parse_manifest(text, [&](const FileEntry& entry) {
    if (!is_safe_relative_path(entry.path)) outside = entry.path;
  });
  if (!json) return damaged(path, "is not JSON");
  if (outside) return damaged(path, "lists a file outside its folder: " + *outside);
  return *json;
}

std::optional<StoredSequenceRow> row_of(const Json& json) {
  const auto sequence = count_at(json, "sequence");
  const auto split = text_at(json, "split");
  const auto sha256 = text_at(json, "sha256");
  const Json* pings = member(json, "pings");
  if (!sequence || *sequence > UINT32_MAX || !split || !sha256 || pings == nullptr) return {};
  if (std::find(std::begin(kSplits), std::end(kSplits), *split) == std::end(kSplits)) return {};
  if (!pings->is_array() || pings->size() != 2) return {};
  if (!(*pings)[0].is_number_unsigned() || !(*pings)[1].is_number_unsigned()) return {};
  const std::uint64_t first = (*pings)[0], last = (*pings)[1];
  if (first > last || last > UINT32_MAX) return {};
  return StoredSequenceRow{static_cast<std::uint32_t>(*sequence), *split,
                           static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last),
                           *sha256};
}

std::optional<std::vector<std::string>> texts_at(const Json& json, std::string_view key) {
  const Json* list = member(json, key);
  if (list == nullptr || !list->is_array()) return std::nullopt;
  std::vector<std::string> texts;
  for (const Json& item : *list) {
    if (!item.is_string()) return std::nullopt;
    texts.push_back(item.get<std::string>());
  }
  return texts;
}

// The member at a path of keys; null where there is none.
const Json* at_path(const Json& json, std::initializer_list<std::string_view> keys) {
  const Json* found = &json;
  for (const std::string_view key : keys) {
    if (found == nullptr) return nullptr;
    found = member(*found, key);
  }
  return found;
}

double number_in(const Json& json, std::initializer_list<std::string_view> keys) {
  const Json* found = at_path(json, keys);
  return found != nullptr && found->is_number() ? found->get<double>() : 0;
}

std::uint64_t count_in(const Json& json, std::initializer_list<std::string_view> keys) {
  const Json* found = at_path(json, keys);
  return found != nullptr && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

std::optional<std::vector<StoredInstance>> instances_of(const Json& head, std::size_t classes) {
  const Json* list = member(head, "instances");
  if (list == nullptr || !list->is_array()) return std::nullopt;
  std::vector<StoredInstance> instances;
  for (const Json& item : *list) {
    const auto id = count_at(item, "id");
    const auto class_id = count_at(item, "class_id");
    const auto name = text_at(item, "name");
    if (id != instances.size() + 1 || *id > UINT16_MAX || !name) return std::nullopt;
    if (!class_id || *class_id < 1 || *class_id > classes || *class_id > UINT8_MAX) {
      return std::nullopt;
    }
    instances.push_back(
        {static_cast<std::uint16_t>(*id), static_cast<std::uint8_t>(*class_id), *name});
  }
  return instances;
}

bool is_plausible(const StoredSequence& s) {
  return s.beams > 0 && s.beams <= kMaxSide && s.samples > 0 && s.samples <= kMaxSide &&
         s.cartesian_height <= kMaxSide && s.cartesian_width <= kMaxSide &&
         s.beams * s.samples <= kMaxPixels && s.cartesian_height * s.cartesian_width <= kMaxPixels;
}

// Masks are as large as the picture that is claimed, so that it is held against its files: deflate
// packs at most 1,032 bytes into one.
bool files_hold_pixels(const StoredDataset& dataset, const StoredSequence& s) {
  const std::uint64_t pixels =
      std::max(s.beams * s.samples, s.cartesian_height * s.cartesian_width);
  bool any = false;
  for (const std::string& name : s.each_ping) {
    const std::string_view folder = std::string_view(name).substr(0, name.find('/'));
    if (folder != "polar" && folder != "cartesian" && folder != "png") continue;
    const auto bytes = listed_file_size(
        dataset.dir,
        layout::in_sequence(s.row.sequence, layout::ping_file(name, s.row.first_ping)));
    if (!bytes) continue;
    any = true;
    if (pixels / 1032 <= *bytes) return true;
  }
  return !any;
}

std::optional<StoredAnnotation> annotation_of(const Json& json, const StoredSequence& sequence,
                                              const StoredPicture& picture) {
  const auto instance = count_at(json, "instance");
  const auto counts = text_at(json, "counts");
  if (!instance || *instance < 1 || *instance > sequence.instances.size() || !counts) {
    return std::nullopt;
  }
  const auto pixels = static_cast<std::int64_t>(picture.width * picture.height);
  auto runs = run_lengths(*counts, pixels);
  if (!runs) return std::nullopt;
  return StoredAnnotation{static_cast<std::uint16_t>(*instance), std::move(*runs),
                          number_at(json, "occlusion")};
}

// Absent in data sets without amodal masks of an older program.
std::optional<std::vector<std::uint16_t>> hidden_of(const Json& image, std::size_t instances) {
  std::vector<std::uint16_t> hidden;
  const Json* list = member(image, "hidden");
  if (list == nullptr) return hidden;
  if (!list->is_array()) return std::nullopt;
  for (const Json& item : *list) {
    const auto instance = count_at(item, "instance");
    if (!instance || *instance < 1 || *instance > instances) return std::nullopt;
    hidden.push_back(static_cast<std::uint16_t>(*instance));
  }
  return hidden;
}

std::optional<StoredPicture> picture_of(const Json& json, const StoredSequence& sequence) {
  const auto view = text_at(json, "view");
  const Json* list = member(json, "annotations");
  if (!view || (*view != "polar" && *view != "cartesian")) return std::nullopt;
  if (list == nullptr || !list->is_array()) return std::nullopt;
  const bool polar = *view == "polar";
  StoredPicture picture;
  picture.view = *view;
  picture.width = polar ? sequence.beams : sequence.cartesian_width;
  picture.height = polar ? sequence.samples : sequence.cartesian_height;
  if (count_at(json, "width") != picture.width || count_at(json, "height") != picture.height) {
    return std::nullopt;
  }
  for (const Json& item : *list) {
    auto annotation = annotation_of(item, sequence, picture);
    if (!annotation) return std::nullopt;
    picture.annotations.push_back(std::move(*annotation));
  }
  auto hidden = hidden_of(json, sequence.instances.size());
  if (!hidden) return std::nullopt;
  picture.hidden = std::move(*hidden);
  return picture;
}

}  // namespace

Error damaged(const fs::path& path, const std::string& what) {
  return {ErrorKind::io,
          fmt::format("{}: {}; `ensonify verify` tells what else is damaged", path.string(), what)};
}

bool StoredSequence::has(std::string_view name_template) const {
  return std::find(each_ping.begin(), each_ping.end(), name_template) != each_ping.end();
}

bool StoredSequence::has_array(std::string_view file) const {
  return packed && std::find(arrays.begin(), arrays.end(), file) != arrays.end();
}

Result<StoredDataset> open_dataset(const fs::path& dir) {
  std::error_code error;
  if (!fs::is_directory(dir, error)) return usage(dir, "no such folder");
  if (!listed_file_size(dir, layout::kDatasetJson) ||
      !listed_file_size(dir, layout::kDatasetSha256)) {
    return listed_file_size(dir, layout::kWorkJson)
               ? usage(dir,
                       "the data set is not finished; give its generate command again, then this")
               : usage(dir,
                       "not a data set of ensonify; accepted is a folder that `ensonify "
                       "generate` has finished");
  }
  const fs::path path = dir / layout::kDatasetJson;
  const auto text = read_file(path, kMaxManifestBytes);
  if (!text) return text.error();
  const auto seal = read_file(dir / layout::kDatasetSha256);
  if (!seal) return seal.error();
  const auto json = manifest_of(path, *text);
  if (json && !count_at(*json, "ensonify_dataset")) {
    return usage(dir, "not a data set of ensonify");
  }
  if (*seal != sha256_hex(*text) + "  " + layout::kDatasetJson + "\n") {
    return damaged(path, "does not have the hash that dataset.sha256 tells");
  }
  if (!json) return json.error();
  if (count_at(*json, "ensonify_dataset") != 1) {
    return usage(dir, "was written by a newer ensonify; use that one");
  }
  const auto name = text_at(*json, "name");
  const auto classes = texts_at(*json, "classes");
  const Json* rows = member(*json, "sequences");
  if (!name || !classes || rows == nullptr || !rows->is_array()) {
    return damaged(path, "lacks its name, classes or sequences");
  }
  StoredDataset dataset{dir, *name, *classes, {}};
  for (const Json& item : *rows) {
    const auto row = row_of(item);
    if (!row) return damaged(path, "lists a sequence without number, pings, split or hash");
    if (!dataset.sequences.empty() && row->sequence <= dataset.sequences.back().sequence) {
      return damaged(path, "lists its sequences twice, or not in their order");
    }
    dataset.sequences.push_back(*row);
  }
  return dataset;
}

Result<StoredSequence> read_sequence(const StoredDataset& dataset, const StoredSequenceRow& row) {
  const std::string relative = layout::in_sequence(row.sequence, layout::kSequenceJson);
  const fs::path path = dataset.dir / relative;
  const auto text = text_of(dataset.dir, relative);
  if (!text) return text.error();
  if (sha256_hex(*text) != row.sha256) {
    return damaged(path, "does not have the hash that dataset.json tells");
  }
  const auto head = manifest_of(path, *text);
  if (!head) return head.error();
  StoredSequence sequence;
  sequence.row = row;
  sequence.packed = text_at(*head, "pack") == "sequence";
  sequence.seed = count_in(*head, {"seed"});
  sequence.beams = count_in(*head, {"sonar", "beams", "count"});
  sequence.samples = count_in(*head, {"record", "samples"});
  sequence.cartesian_height = count_in(*head, {"cartesian", "height_px"});
  sequence.cartesian_width = count_in(*head, {"cartesian", "width_px"});
  sequence.metres_per_pixel = number_in(*head, {"cartesian", "metres_per_pixel"});
  sequence.frequency_hz = number_in(*head, {"sonar", "frequency_hz"});
  sequence.sound_speed_m_s = number_in(*head, {"water", "sound_speed_m_s"});
  sequence.range_step_m = number_in(*head, {"record", "range_step_m"});
  sequence.beam_width_rad = number_in(*head, {"sonar", "beams", "width_rad"});
  sequence.elevation_width_rad = number_in(*head, {"sonar", "elevation", "width_rad"});
  if (const Json* arrays = member(*head, "arrays"); arrays != nullptr && arrays->is_object()) {
    for (const auto& array : arrays->items()) sequence.arrays.push_back(array.key());
  }
  auto instances = instances_of(*head, dataset.classes.size());
  auto each_ping = texts_at(*head, "each_ping");
  if (!instances || !each_ping || !is_plausible(sequence) ||
      count_at(*head, "sequence") != row.sequence) {
    return damaged(path, "lacks its geometry, instances or files");
  }
  sequence.instances = std::move(*instances);
  sequence.each_ping = std::move(*each_ping);
  if (!files_hold_pixels(dataset, sequence)) {
    return damaged(path, "claims more pixels than its pictures have");
  }
  return sequence;
}

Result<std::vector<StoredPicture>> pictures_of(const StoredDataset& dataset,
                                               const StoredSequence& sequence,
                                               const StoredPing& ping) {
  const auto broken = [&] {
    const std::string relative = layout::in_sequence(sequence.row.sequence, layout::kAnnotations);
    return damaged(dataset.dir / relative, fmt::format("its line of ping {} is wrong", ping.ping));
  };
  const auto json = parse_json(ping.annotation_line);
  const Json* images = json ? member(*json, "images") : nullptr;
  if (images == nullptr || !images->is_array() || count_at(*json, "ping") != ping.ping) {
    return broken();
  }
  std::vector<StoredPicture> pictures;
  for (const Json& image : *images) {
    auto picture = picture_of(image, sequence);
    if (!picture) return broken();
    pictures.push_back(std::move(*picture));
  }
  return pictures;
}

Result<fs::path> stored_file(const StoredDataset& dataset, std::uint32_t sequence,
                             std::string_view name) {
  const std::string relative = layout::in_sequence(sequence, name);
  if (!listed_file_size(dataset.dir, relative)) {
    return damaged(dataset.dir / relative, "is missing, or is no file of this folder");
  }
  return dataset.dir / relative;
}

Result<fs::path> ping_file(const StoredDataset& dataset, std::uint32_t sequence,
                           std::string_view name_template, std::uint32_t ping) {
  return stored_file(dataset, sequence, layout::ping_file(name_template, ping));
}

}  // namespace ensonify
