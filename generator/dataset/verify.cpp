#include "dataset/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "dataset/catalogue.h"
#include "dataset/layout.h"
#include "dataset/manifest_json.h"
#include "dataset/schema.h"
#include "dataset/verify_parts.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

// The schema of a manifest and of the entries of its list of files.
struct ManifestSchema {
  SchemaCheck whole, entry;
  explicit ManifestSchema(std::string_view name) : whole(name), entry(name, "file") {}
};

struct Verification {
  const fs::path& dir;
  const Workers& workers;
  VerifyReport report;
  std::set<std::string> known;  // listed by a manifest, or a manifest
  std::vector<SequenceShape> shapes;
  const ManifestSchema sequence_schema{"sequence"};
  DisplayCounts images = {};  // over the sequences so far
  std::optional<std::array<double, 2>> limits_db = {};

  void fault(const std::string& relative, const std::string& what) {
    if (!what.empty()) report.faults.push_back(relative + ": " + what);
  }
};

struct Manifest {
  Json head;  // all but its list of files
  std::vector<FileEntry> entries;
  std::string schema_fault;
};

std::optional<Manifest> read_manifest(std::string_view text, const ManifestSchema& schema) {
  Manifest manifest;
  auto head = parse_manifest_entries(text, [&](const Json& entry) {
    if (manifest.schema_fault.empty()) {
      manifest.schema_fault =
          schema.entry.fault(entry, fmt::format("/files/{}", manifest.entries.size()));
    }
    manifest.entries.push_back(file_entry_of(entry).value_or(FileEntry{}));
  });
  if (!head) return std::nullopt;
  if (std::string fault = schema.whole.fault(*head); !fault.empty()) {
    manifest.schema_fault = std::move(fault);
  }
  manifest.head = std::move(*head);
  return manifest;
}

std::optional<SequenceShape> shape_of(const std::optional<SequenceManifest>& manifest) {
  if (!manifest) return std::nullopt;
  const SequenceInfo& info = manifest->info;
  SequenceShape shape{info.sequence,         info.split, info.first_ping, info.last_ping,
                      info.instances.size(), 0,          sizes_of(info),  info.output.labels};
  const bool has_fan = shape.sizes.beams > 0 && shape.sizes.samples > 0;
  if (info.split.empty() || (is_sonar(info) && !has_fan)) return std::nullopt;
  shape.boxes = static_cast<std::uint64_t>(
      std::count_if(info.instances.begin(), info.instances.end(),
                    [](const Instance& instance) { return instance.box.has_value(); }));
  return shape;
}

constexpr std::size_t kLongestTemplate = 64;

// File names that a sequence must list, with the template of each.
std::vector<std::pair<std::string, std::string>> expected_files(const SequenceManifest& manifest) {
  const SequenceInfo& info = manifest.info;
  std::vector<std::pair<std::string, std::string>> names;
  for (const CatalogueRow& row : catalogue()) {
    if (row.scope != FileScope::sequence || row.file == layout::kSequenceJson) continue;
    if (!is_wanted(row, selection_of(info))) continue;
    // Earlier versions had fewer arrays of statistics.
    const bool is_listed =
        !row.file.starts_with("statistics/") ||
        std::ranges::find(manifest.statistics, row.file) != manifest.statistics.end();
    if (is_listed) names.emplace_back(row.file, row.file);
  }
  for (const std::string& name : manifest.arrays) names.emplace_back(name, name);
  for (const std::string& name_template : manifest.each_ping) {
    // Not one of our templates; copies of it for every ping could fill the memory.
    if (name_template.size() > kLongestTemplate) continue;
    for (auto ping = info.first_ping; ping < info.last_ping; ++ping) {
      names.emplace_back(layout::ping_file(name_template, ping), name_template);
    }
  }
  return names;
}

void check_listed_files(Verification& v, const SequenceShape& shape,
                        const SequenceManifest& manifest, const std::vector<FileEntry>& entries) {
  const std::string folder = layout::sequence_folder(shape.sequence) + "/";
  if (manifest.info.output.packed != manifest.has_arrays) {
    v.fault(folder + layout::kSequenceJson, "its members pack and arrays contradict each other");
  }
  if (manifest.info.output.statistics && manifest.realisations != shape.pings()) {
    v.fault(folder + layout::kSequenceJson, "its statistics do not cover all its pings");
  }
  if (shape.pings() * manifest.each_ping.size() > entries.size()) {
    // This check also prevents a manifest that claims billions of pings from filling the memory.
    v.fault(folder + layout::kSequenceJson, "lists fewer files than its pings have");
    return;
  }
  std::map<std::string, std::string> templates;
  for (auto& [name, name_template] : expected_files(manifest)) templates[name] = name_template;

  std::vector<std::string> faults(entries.size());
  v.workers.for_each(entries.size(), [&](std::size_t i) {
    const FileEntry& entry = entries[i];
    const auto known = templates.find(entry.path);
    faults[i] = content_fault(v.dir, folder + entry.path, entry.bytes, entry.sha256);
    if (!faults[i].empty()) return;
    faults[i] = known == templates.end() ? "is listed, but not a file of this sequence"
                                         : format_fault(v.dir, shape, entry.path, known->second);
  });
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    v.fault(folder + entries[i].path, faults[i]);
    v.known.insert(folder + entries[i].path);
    if (templates.erase(entries[i].path) == 0 && faults[i].empty()) {
      v.fault(folder + entries[i].path, "is listed twice");
    }
    bytes += entries[i].bytes;
  }
  for (const auto& [name, name_template] : templates) {
    v.fault(folder + name, "belongs to this sequence, but sequence.json does not list it");
  }
  if (manifest.bytes != bytes) {
    v.fault(folder + layout::kSequenceJson, "its number of bytes is not the sum of its files");
  }
  v.report.files += entries.size();
  v.report.bytes += bytes;
}

void check_sequence(Verification& v, const SequenceEntry& row) {
  if (row.sha256.empty()) {
    return v.fault(layout::kDatasetJson, "a sequence has no number or hash");
  }
  const std::uint32_t sequence = row.sequence;
  const std::string path = layout::in_sequence(sequence, layout::kSequenceJson);
  if (!v.known.insert(path).second) return v.fault(path, "the sequence is listed twice");
  const auto size = listed_file_size(v.dir, path);
  v.fault(path, content_fault(v.dir, path, size.value_or(0), row.sha256));
  if (!size) return;
  ++v.report.files;
  v.report.bytes += *size;

  const auto text = read_file(v.dir / path);
  auto manifest = text ? read_manifest(*text, v.sequence_schema) : std::nullopt;
  if (!manifest) return v.fault(path, "is not JSON");
  v.fault(path, manifest->schema_fault);
  const auto head = read_sequence_head(manifest->head);
  const auto shape = shape_of(head);
  if (!shape) return v.fault(path, "has no pings, beams, samples, split or instances");
  const SequenceInfo& info = head->info;
  if (info.sequence != sequence || info.first_ping != row.first_ping ||
      info.last_ping != row.last_ping || row.split != info.split || row.seed != info.seed) {
    return v.fault(path, "differs from dataset.json");
  }
  v.shapes.push_back(*shape);
  if (info.output.png) {
    v.images += info.png_counts;
    if (v.limits_db.value_or(info.png.limits_db) != info.png.limits_db) {
      v.fault(path, "its limits of 8-bit images differ from those of the sequences before it");
    }
    v.limits_db = info.png.limits_db;
  }
  check_listed_files(v, *shape, *head, manifest->entries);
}

// Its folder, if it has one, is a file that no manifest lists.
void check_failed(Verification& v, std::vector<SequenceFailure> failed) {
  std::set<std::uint32_t> numbers;
  for (const SequenceFailure& failure : failed) {
    const bool is_made =
        v.known.contains(layout::in_sequence(failure.sequence, layout::kSequenceJson));
    if (is_made || !numbers.insert(failure.sequence).second) {
      v.fault(layout::kDatasetJson,
              fmt::format("lists sequence {} as failed and {}", failure.sequence,
                          is_made ? "as made" : "a second time"));
    }
  }
  v.report.failed = std::move(failed);
}

void check_top_level_files(Verification& v, const std::vector<FileEntry>& entries) {
  for (const FileEntry& entry : entries) {
    const bool asset = entry.path.starts_with("assets/");
    v.fault(entry.path, content_fault(v.dir, entry.path, entry.bytes, entry.sha256));
    if (!asset && find_file(FileScope::dataset, entry.path) == nullptr) {
      v.fault(entry.path, "is listed, but not a file of a data set");
    }
    if (asset && !entry.path.starts_with("assets/" + entry.sha256)) {
      v.fault(entry.path, "does not have the listed hash");
    }
    v.known.insert(entry.path);
    ++v.report.files;
    v.report.bytes += entry.bytes;
  }
  // Data sets of earlier versions have no croissant.json.
  for (const CatalogueRow& row : catalogue()) {
    if (row.scope != FileScope::dataset) continue;
    const std::string& name = row.file;
    const bool own = name == layout::kDatasetJson || name == layout::kDatasetSha256 ||
                     name == layout::kProvenanceJson;
    if (own) {
      v.known.insert(name);
    } else if (!v.known.contains(name) && name != layout::kCroissantJson) {
      v.fault(name, "is not listed in dataset.json");
    }
  }
}

void check_tables(Verification& v, const Json& manifest) {
  // The check of hashes has already reported missing tables.
  const auto check = [&](const std::string& name, const auto& fault_of) {
    if (listed_file_size(v.dir, name)) v.fault(name, fault_of(v.dir / name));
  };
  check("index.csv", [&](const fs::path& path) { return index_fault(path, v.shapes); });
  for (const std::string split : {"train", "val", "test"}) {
    check("splits/" + split + ".txt",
          [&](const fs::path& path) { return split_fault(path, split, v.shapes); });
  }
  const Json* classes = member(manifest, "classes");
  check("coco.json", [&](const fs::path& path) {
    return coco_fault(path, v.known, classes != nullptr ? classes->size() : 0);
  });
  check(layout::kWorkJson, [&](const fs::path& path) -> std::string {
    const auto text = read_file(path);
    const auto work = text ? parse_json(*text) : std::nullopt;
    if (!work) return "is not JSON";
    if (std::string fault = SchemaCheck("work").fault(*work); !fault.empty()) return fault;
    for (const char* key : {"name", "scenario_sha256", "seed", "program", "numerics"}) {
      const Json* here = member(*work, key);
      const Json* there = member(manifest, key);
      if (here == nullptr || there == nullptr || *here != *there) {
        return fmt::format("differs from dataset.json in {}", key);
      }
    }
    return {};
  });
}

void check_unlisted(Verification& v) {
  const auto found = files_below(v.dir);
  if (!found) return v.fault(v.dir.string(), found.error().message);
  bool work = false;
  for (const std::string& path : *found) {
    if (path.starts_with(std::string(layout::kWorkFolder) + "/")) {
      work = true;
    } else if (!v.known.contains(path)) {
      v.fault(path, "is not listed in any manifest");
    }
  }
  if (work) {
    v.fault(layout::kWorkFolder,
            "is still there: a run was interrupted or is still writing; run the "
            "generate command again");
  }
}

void check_all_renders(Verification& v, std::span<const SequenceEntry> entries) {
  const RenderFindings found = check_renders(v.dir, v.shapes, entries, v.workers);
  for (const auto& [path, fault] : found.faults) v.fault(path, fault);
  v.known.insert(found.files.begin(), found.files.end());
  v.report.files += found.files.size();
  v.report.bytes += found.bytes;
}

// The display of all sequences, and its counts.
void check_images(Verification& v, const DatasetManifest& manifest) {
  if (!manifest.png) return;
  if (v.images != manifest.png_counts) {
    v.fault(layout::kDatasetJson, "its counts of pixels in png are not the sums of its sequences");
  }
  if (v.limits_db != manifest.png->limits_db) {
    v.fault(layout::kDatasetJson, "its limits in png are not those of its sequences");
  }
}

void check_manifest(Verification& v) {
  if (!listed_file_size(v.dir, layout::kDatasetJson)) {
    return v.fault(layout::kDatasetJson,
                   "is missing: the data set is not finished; run the generate command again");
  }
  const auto text = read_file(v.dir / layout::kDatasetJson, kMaxManifestBytes);
  if (!text) return v.fault(layout::kDatasetJson, text.error().message);
  const auto seal = listed_file_size(v.dir, layout::kDatasetSha256)
                        ? read_file(v.dir / layout::kDatasetSha256)
                        : Result<std::string>(std::string());
  if (!seal || *seal != sha256_hex(*text) + "  " + layout::kDatasetJson + "\n") {
    v.fault(layout::kDatasetSha256, "is missing or does not agree with dataset.json");
  }
  v.report.files += 2;
  v.report.bytes += text->size() + (seal ? seal->size() : 0);

  const auto manifest = read_manifest(*text, ManifestSchema("dataset"));
  if (!manifest) return v.fault(layout::kDatasetJson, "is not JSON");
  v.fault(layout::kDatasetJson, manifest->schema_fault);
  check_top_level_files(v, manifest->entries);
  if (auto head = read_dataset_head(manifest->head)) {
    for (const SequenceEntry& row : head->sequences) check_sequence(v, row);
    v.report.sequences = head->sequences.size();
    check_images(v, *head);
    check_all_renders(v, head->sequences);
    check_failed(v, std::move(head->failed));
  }
  check_tables(v, manifest->head);
  check_unlisted(v);
}

// Whether any file in the folder is marked by ensonify. One flipped bit must not make the folder
// foreign.
bool is_ours(const fs::path& dir) {
  const std::pair<const char*, const char*> marks[] = {{layout::kWorkJson, "ensonify_work"},
                                                       {layout::kDatasetJson, "ensonify_dataset"}};
  return std::any_of(std::begin(marks), std::end(marks), [&](const auto& mark) {
    if (!listed_file_size(dir, mark.first)) return false;
    const auto text = read_file(dir / mark.first, kMaxManifestBytes);
    const auto json = text ? parse_json(*text) : std::nullopt;
    return json && count_at(*json, mark.second);
  });
}

}  // namespace

Result<VerifyReport> verify_dataset(const fs::path& dir, const Workers& workers) {
  return without_exceptions("verifying " + dir.string(), [&]() -> Result<VerifyReport> {
    std::error_code error;
    const fs::directory_iterator readable(dir, error);
    if (error) return read_error(dir, error.value());
    if (!is_ours(dir)) {
      return Error{ErrorKind::usage, dir.string() + ": not a data set of ensonify"};
    }
    Verification verification{dir, workers, {}, {}, {}};
    check_manifest(verification);
    return std::move(verification.report);
  });
}

}  // namespace ensonify
