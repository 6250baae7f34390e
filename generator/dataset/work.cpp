#include "dataset/work.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <vector>

#include "core/counted.h"
#include "dataset/layout.h"
#include "dataset/manifest_json.h"
#include "dataset/overwrite.h"
#include "dataset/packed.h"
#include "dataset/work_folder.h"
#include "formats/files.h"
#include "formats/json.h"
#include "formats/sha256.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

// The parts of a folder's content that show to which run it belongs.
struct Folder {
  bool empty = true;  // but for temporary files of a start that was cut off
  std::optional<std::string> work_text;
  std::optional<Json> work;  // valid
  std::optional<DatasetManifest> dataset;
  bool sealed = false;                 // dataset.sha256 agrees with dataset.json
  std::uint64_t sequences_sealed = 0;  // and those that cannot be made
  std::uint64_t sequences_begun = 0;   // highest number of a sequence's folder, plus one
};

std::optional<std::string> text_of(const fs::path& dir, const char* name) {
  if (!listed_file_size(dir, name)) return std::nullopt;
  auto text = read_file(dir / name, kMaxManifestBytes);
  return text ? std::optional(std::move(*text)) : std::nullopt;
}

// Returns a link that stands in place of one of our folders, down to those of a sequence; empty if
// there is none. Files need no check: writing replaces a link, and removing removes the link.
std::string link_among(const fs::path& dir, const std::string& relative, int levels) {
  std::error_code error;
  for (fs::directory_iterator entry(dir / relative, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    const std::string name = relative + "/" + entry->path().filename().string();
    if (entry->is_symlink(ignored)) {
      if (fs::is_directory(entry->path(), ignored)) return name;
    } else if (levels > 1 && entry->is_directory(ignored)) {
      if (std::string found = link_among(dir, name, levels - 1); !found.empty()) return found;
    }
  }
  return {};
}

std::string link_among_folders(const fs::path& dir) {
  for (const char* const top : {"sequences", "assets", "splits", layout::kWorkFolder}) {
    std::error_code error;
    const fs::file_status status = fs::symlink_status(dir / top, error);
    if (fs::is_symlink(status)) return top;
    if (!fs::is_directory(status)) continue;
    if (std::string found = link_among(dir, top, 2); !found.empty()) return found;
  }
  return {};
}

// The highest number of a started sequence, plus one.
std::uint64_t begun_sequences(const fs::path& dir) {
  const std::vector<std::uint32_t> numbers = sequence_numbers(dir);
  return numbers.empty() ? 0 : std::uint64_t{numbers.back()} + 1;
}

// Whether the folder holds no files, except leftovers of an interrupted start in .work/tmp.
bool holds_nothing(const fs::path& dir, std::error_code& error) {
  for (fs::recursive_directory_iterator entry(dir, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    if (fs::is_directory(entry->symlink_status(ignored))) continue;
    if (entry->path().parent_path() != dir / layout::kTemporaryFolder) return false;
  }
  return true;
}

Result<Folder> look_at(const fs::path& dir) {
  Folder folder;
  std::error_code error;
  folder.empty = holds_nothing(dir, error);
  if (error) return read_error(dir, error.value());

  folder.work_text = text_of(dir, layout::kWorkJson);
  if (folder.work_text) folder.work = parse_json(*folder.work_text);
  if (folder.work && !count_at(*folder.work, "ensonify_work")) folder.work.reset();

  const auto manifest = text_of(dir, layout::kDatasetJson);
  const auto head = manifest ? parse_manifest(*manifest, [](const FileEntry&) {}) : std::nullopt;
  if (head) folder.dataset = read_dataset_head(*head);
  if (folder.dataset) {
    const auto seal = text_of(dir, layout::kDatasetSha256);
    folder.sealed = seal == sha256_hex(*manifest) + "  " + layout::kDatasetJson + "\n";
    folder.sequences_sealed = folder.dataset->sequences.size() + folder.dataset->failed.size();
  }
  folder.sequences_begun = std::max(folder.sequences_sealed, begun_sequences(dir));
  return folder;
}

// "seed (7, now 8)" for every member in which two work.json differ.
std::vector<std::string> differences(const Json& held, const Json& asked) {
  static constexpr const char* kMembers[][2] = {
      {"/name", "scenario name"},
      {"/scenario_sha256", "scenario"},
      {"/seed", "seed"},
      {"/pings", "pings"},
      {"/program/version", "version"},
      {"/program/commit", "commit"},
      {"/numerics/backend", "backend"},
      {"/numerics/simd", "SIMD level"},
      {"/numerics/embree_isa", "Embree's instruction set"}};
  std::vector<std::string> list;
  for (const auto& [pointer, label] : kMembers) {
    const Json::json_pointer at(pointer);
    const Json was = held.contains(at) ? held.at(at) : Json(nullptr);
    const Json now = asked.at(at);
    if (was == now) continue;
    const bool hash = std::string_view(label) == "scenario";
    list.push_back(hash ? label
                        : fmt::format("{} ({}, now {})", label, json_line(was), json_line(now)));
  }
  return list;
}

Error refused(const fs::path& dir, const std::string& why, bool ours) {
  return {ErrorKind::usage,
          fmt::format("{}: {}; name another folder{}", dir.string(), why,
                      ours ? ", or give --overwrite to remove the old data set" : "")};
}

Error refused_other_work(const fs::path& dir, const Folder& folder, const std::string& asked) {
  if (!folder.work) {
    return refused(dir, "holds a data set of ensonify, but no readable work.json", true);
  }
  const auto list = differences(*folder.work, *parse_json(asked));
  return refused(dir,
                 list.empty() ? std::string("holds the data set of another run")
                              : fmt::format("holds the data set of another run: it differs in {}",
                                            fmt::join(list, ", ")),
                 true);
}

Result<FolderState> start(const fs::path& dir, const std::string& work_text) {
  const auto written = write_file_atomically(dir, layout::kWorkJson, work_text);
  if (!written) return written.error();
  return FolderState::started;
}

Result<FolderState> empty_and_start(const fs::path& dir, const std::string& work_text) {
  if (FolderUse::is_used(dir)) {
    return Error{ErrorKind::usage,
                 dir.string() +
                     ": another process is writing to it; end that process first, or "
                     "name another folder"};
  }
  const auto inventory = take_inventory(dir);
  if (!inventory) return inventory.error();
  if (const auto removed = remove_listed(dir, *inventory); !removed) return removed.error();
  return start(dir, work_text);
}

// A sequence.json that lists files which are gone (an --overwrite was cut off, or somebody cleaned
// up) would pass as a finished sequence: removes it, so that the sequence is made again.
Status drop_broken_sequences(const fs::path& dir, std::uint64_t begun) {
  for (std::uint64_t number = 0; number < begun; ++number) {
    const auto sequence = static_cast<std::uint32_t>(number);
    const auto path = dir / layout::in_sequence(sequence, layout::kSequenceJson);
    std::error_code error;
    if (!fs::exists(fs::symlink_status(path, error)) || sequence_is_whole(dir, sequence)) continue;
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) return write_error(path, errno);
  }
  return {};
}

// Removes files that another, interrupted process with the same work may have left.
FolderState complete(const fs::path& dir) {
  for (const std::uint32_t sequence : sequence_numbers(dir)) remove_pieces(dir, sequence);
  remove_work_folder(dir);
  return FolderState::complete;
}

Result<FolderState> open_folder(const fs::path& dir, const WorkIdentity& identity,
                                std::uint32_t sequences, bool overwrite, bool keep_sealed) {
  if (const std::string link = link_among_folders(dir); !link.empty()) {
    return refused(
        dir, fmt::format("`{}` in it is a link to something that ensonify did not make", link),
        false);
  }
  const auto folder = look_at(dir);
  if (!folder) return folder.error();
  if (keep_sealed && folder->sealed) return complete(dir);
  const std::string asked = to_json(identity);
  if (folder->empty) return start(dir, asked);
  if (!folder->work && !folder->dataset) {
    return refused(dir, "is not empty, and ensonify did not make its contents", false);
  }
  if (folder->work_text != asked) {
    if (overwrite) return empty_and_start(dir, asked);
    return refused_other_work(dir, *folder, asked);
  }
  if (folder->sequences_begun > sequences) {
    if (overwrite) return empty_and_start(dir, asked);
    return refused(dir,
                   fmt::format("holds {} of this run, more than the requested {}; their number may "
                               "grow, not shrink",
                               counted(folder->sequences_begun, "sequence"), sequences),
                   true);
  }
  if (!folder->sealed || folder->sequences_sealed < sequences) {
    const Status dropped = drop_broken_sequences(dir, folder->sequences_begun);
    if (!dropped) return dropped.error();
    return FolderState::continued;
  }
  if (overwrite) return empty_and_start(dir, asked);
  return complete(dir);
}

}  // namespace

std::string to_json(const WorkIdentity& identity) { return json_text(work_json(identity)); }

bool is_sealed(const fs::path& dir) {
  const auto manifest = text_of(dir, layout::kDatasetJson);
  return manifest && text_of(dir, layout::kDatasetSha256) ==
                         sha256_hex(*manifest) + "  " + layout::kDatasetJson + "\n";
}

Result<FolderState> open_work(const fs::path& dir, const WorkIdentity& identity,
                              std::uint32_t sequences, bool overwrite, bool keep_sealed,
                              FolderUse* use) {
  return without_exceptions("opening " + dir.string(), [&]() -> Result<FolderState> {
    std::error_code error;
    fs::create_directories(dir, error);
    if (error) return write_error(dir, error.value());
    if (!fs::is_directory(dir, error)) return write_error(dir, ENOTDIR);
    const FolderLock lock(dir);
    auto state = open_folder(dir, identity, sequences, overwrite, keep_sealed);
    if (state && use != nullptr) *use = FolderUse(dir);
    return state;
  });
}

}  // namespace ensonify
