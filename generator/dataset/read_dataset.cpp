#include "dataset/read_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/layout.h"
#include "dataset/manifest_json.h"
#include "dataset/mask.h"
#include "dataset/rig_file.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

// Larger files count as damaged, before memory is allocated.
constexpr std::uint64_t kMaxSide = 1'000'000;
constexpr double kMaxRangeM = 1e7;
constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 31;

Error usage(const fs::path& dir, const std::string& what) {
  return {ErrorKind::usage, dir.string() + ": " + what};
}

Result<std::string> text_of(const fs::path& dir, const std::string& relative) {
  if (!listed_file_size(dir, relative)) {
    return damaged(dir / relative, "is missing, or is not a file of this folder");
  }
  return read_file(dir / relative);
}

// A manifest whose files are all inside the folder.
Result<Json> manifest_of(const fs::path& path, std::string_view text) {
  std::optional<std::string> outside;
  const auto json = parse_manifest(text, [&](const FileEntry& entry) {
    if (!is_safe_relative_path(entry.path)) outside = entry.path;
  });
  if (!json) return damaged(path, "is not JSON");
  if (outside) return damaged(path, "lists a file outside its folder: " + *outside);
  return *json;
}

// Whether the ids match the positions in the list and the data set's classes.
bool are_numbered(const std::vector<Instance>& instances, std::size_t classes) {
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const Instance& instance = instances[i];
    if (instance.id != i + 1 || instance.class_id < 1 || instance.class_id > classes) return false;
  }
  return true;
}

StoredSequence stored_sequence(const StoredSequenceRow& row, SequenceManifest manifest) {
  const SequenceInfo& info = manifest.info;
  const GridSizes sizes = sizes_of(info);
  StoredSequence sequence;
  sequence.row = row;
  sequence.seed = info.seed;
  sequence.beams = sizes.beams;
  sequence.samples = sizes.samples;
  sequence.elements = sizes.elements;
  sequence.cartesian_height = sizes.cartesian_height;
  sequence.cartesian_width = sizes.cartesian_width;
  sequence.ray_elevations = sizes.elevations;
  sequence.ray_azimuths = sizes.azimuths;
  sequence.metres_per_pixel = info.cartesian ? info.cartesian->m_per_px : 0;
  sequence.frequency_hz = info.sonar.frequency_hz;
  sequence.sound_speed_m_s = info.water.sound_speed_m_s;
  sequence.range_step_m = range_step_m(info.sonar, info.water);
  sequence.first_range_m = info.sonar.first_range_m;
  sequence.beam_width_rad = info.sonar.beam_width_rad;
  sequence.elevation_width_rad = info.sonar.elevation_width_rad;
  sequence.instances = info.instances;
  sequence.each_ping = manifest.each_ping;
  sequence.packed = info.output.packed;
  sequence.arrays = manifest.arrays;
  sequence.manifest = std::move(manifest);
  return sequence;
}

// Whether azimuths rise, widths are as many as beams, and the first range is finite.
bool is_fan(const StoredSequence& s) {
  const Sonar& sonar = s.manifest.info.sonar;
  const auto& azimuths = sonar.azimuth_rad;
  for (std::size_t i = 0; i < azimuths.size(); ++i) {
    if (!(std::abs(azimuths[i]) < 7) || (i > 0 && !(azimuths[i - 1] < azimuths[i]))) return false;
  }
  if (!sonar.width_rad.empty() && sonar.width_rad.size() != s.beams) return false;
  return (azimuths.empty() || (azimuths.size() == s.beams && s.beams > 1)) &&
         s.first_range_m >= 0 && s.first_range_m <= kMaxRangeM;
}

// Only the directions of a front view are sizes of arrays.
bool has_plausible_rays(const StoredSequence& s) {
  if (!s.manifest.info.output.front) return true;
  return s.ray_elevations > 0 && s.ray_elevations <= kMaxPixels && s.ray_azimuths > 0 &&
         s.ray_azimuths <= kMaxPixels && s.ray_elevations * s.ray_azimuths <= kMaxPixels;
}

bool has_plausible_camera(const StoredSequence& s) {
  const GridSizes sizes = s.sizes();
  return sizes.camera_height <= kMaxSide && sizes.camera_width <= kMaxSide &&
         sizes.camera_height * sizes.camera_width <= kMaxPixels;
}

bool is_plausible(const StoredSequence& s) {
  if (!is_sonar(s.manifest.info)) return has_plausible_camera(s);
  return s.beams > 0 && s.beams <= kMaxSide && s.samples > 0 && s.samples <= kMaxSide &&
         is_fan(s) && s.cartesian_height <= kMaxSide && s.cartesian_width <= kMaxSide &&
         s.beams * s.samples <= kMaxPixels &&
         s.cartesian_height * s.cartesian_width <= kMaxPixels && has_plausible_rays(s) &&
         has_plausible_camera(s);
}

// Masks have the claimed size of the image, so it is compared with the size of its files: deflate
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
                          number_at(json, "occlusion"), count_at(json, "amodal_area")};
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

bool StoredSequence::has(std::string_view name_template) const {
  return std::find(each_ping.begin(), each_ping.end(), name_template) != each_ping.end();
}

bool StoredSequence::has_array(std::string_view file) const {
  return packed && std::find(arrays.begin(), arrays.end(), file) != arrays.end();
}

bool StoredSequence::has(const CatalogueRow& r) const {
  // The labels' file is that of the level, too.
  const bool label = r.plane != nullptr && !is_level_plane(*r.plane);
  if (label && !manifest.info.output.labels) return false;
  if (r.front_plane != nullptr && !manifest.info.output.front) return false;
  return packed && !r.array.empty() ? has_array(r.array) : has(r.file);
}

GridSizes StoredSequence::sizes() const {
  GridSizes sizes = {.beams = beams,
                     .samples = samples,
                     .elements = elements,
                     .cartesian_height = cartesian_height,
                     .cartesian_width = cartesian_width,
                     .elevations = ray_elevations,
                     .azimuths = ray_azimuths,
                     .pings = row.pings()};
  if (const auto& map = manifest.info.height_map) {
    sizes.height_rows = static_cast<std::uint64_t>(map->rows);
    sizes.height_columns = static_cast<std::uint64_t>(map->columns);
  }
  if (const auto& camera = manifest.info.camera) {
    sizes.camera_height = static_cast<std::uint64_t>(camera->optics.height_px);
    sizes.camera_width = static_cast<std::uint64_t>(camera->optics.width_px);
  }
  return sizes;
}

// The reason why a folder is not a finished data set.
static std::string why_unreadable(const fs::path& dir) {
  if (listed_file_size(dir, layout::kWorkJson)) {
    return "the data set is not finished; run its generate command again, then this one";
  }
  if (const auto rig = read_rig(dir); rig && *rig) {
    std::string folders;
    for (const RigInstrument& instrument : (*rig)->instruments) {
      folders += (folders.empty() ? "" : ", ") + (dir / instrument.name).string();
    }
    return "a rig; expected the data set of one of its instruments: " + folders;
  }
  if (listed_file_size(dir, "plan.jsonl")) {
    return "a sweep; expected one of its runs, a folder of " + (dir / "runs").string() +
           " (index.json lists them)";
  }
  return "not a data set of ensonify; expected a folder that `ensonify generate` has finished";
}

Result<StoredDataset> open_dataset(const fs::path& dir) {
  std::error_code error;
  if (!fs::is_directory(dir, error)) return usage(dir, "no such folder");
  if (!listed_file_size(dir, layout::kDatasetJson) ||
      !listed_file_size(dir, layout::kDatasetSha256)) {
    return usage(dir, why_unreadable(dir));
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
    return damaged(path, "does not have the hash given in dataset.sha256");
  }
  if (!json) return json.error();
  if (count_at(*json, "ensonify_dataset") != 1) {
    return usage(dir, "was written by a newer ensonify; use that version");
  }
  auto manifest = read_dataset_head(*json);
  const auto lacks = [&](const char* key) { return member(*json, key) == nullptr; };
  if (!manifest || manifest->identity.name.empty() || lacks("classes") || lacks("sequences")) {
    return damaged(path, "has no name, classes or sequences");
  }
  std::optional<std::uint32_t> before;
  for (const SequenceEntry& row : manifest->sequences) {
    const auto& splits = layout::kSplits;
    const bool is_split = std::find(splits.begin(), splits.end(), row.split) != splits.end();
    if (!manifest->fault.empty() || !is_split || row.sha256.empty()) {
      return damaged(path, "lists a sequence without a number, pings, split or hash");
    }
    if (before && row.sequence <= *before) {
      return damaged(path, "lists a sequence twice, or not in order");
    }
    before = row.sequence;
  }
  if (!manifest->fault.empty()) return damaged(path, "has a wrong member " + manifest->fault);
  const DatasetManifest& m = *manifest;
  if (m.class_kinds.size() != m.classes.size()) {
    return damaged(path, "does not have a kind in class_kinds for each of its classes");
  }
  return StoredDataset{dir, m, m.identity.name, m.classes, m.class_kinds, m.sequences};
}

Result<StoredSequence> read_sequence(const StoredDataset& dataset, const StoredSequenceRow& row) {
  const std::string relative = layout::in_sequence(row.sequence, layout::kSequenceJson);
  const fs::path path = dataset.dir / relative;
  const auto text = text_of(dataset.dir, relative);
  if (!text) return text.error();
  if (sha256_hex(*text) != row.sha256) {
    return damaged(path, "does not have the hash given in dataset.json");
  }
  const auto head = manifest_of(path, *text);
  if (!head) return head.error();
  auto manifest = read_sequence_head(*head);
  const bool has_lists =
      member(*head, "instances") != nullptr && member(*head, "each_ping") != nullptr;
  if (!manifest || !manifest->fault.empty() || !has_lists ||
      manifest->info.sequence != row.sequence) {
    return damaged(path, "has no geometry, instances or files");
  }
  StoredSequence sequence = stored_sequence(row, std::move(*manifest));
  if (!is_plausible(sequence) || !are_numbered(sequence.instances, dataset.classes.size())) {
    return damaged(path, "has no geometry, instances or files");
  }
  if (!files_hold_pixels(dataset, sequence)) {
    return damaged(path, "gives more pixels than its images have");
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
    return damaged(dataset.dir / relative, "is missing, or is not a file of this folder");
  }
  return dataset.dir / relative;
}

Result<fs::path> ping_file(const StoredDataset& dataset, std::uint32_t sequence,
                           std::string_view name_template, std::uint32_t ping) {
  return stored_file(dataset, sequence, layout::ping_file(name_template, ping));
}

}  // namespace ensonify
