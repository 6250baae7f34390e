#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <optional>
#include <set>
#include <utility>

#include "dataset/coco.h"
#include "dataset/finish.h"
#include "dataset/layout.h"
#include "dataset/manifest_json.h"
#include "dataset/overwrite.h"
#include "dataset/packed.h"
#include "dataset/table_rows.h"
#include "dataset/work.h"
#include "dataset/work_folder.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

std::string asset_name(const Asset& asset) {
  const std::size_t dots = asset.extension.starts_with('.') ? 1 : 0;
  const std::string extension = asset.extension.substr(dots);
  return "assets/" + asset.sha256 + (extension.empty() ? "" : "." + extension);
}

Result<FileEntry> copy_asset(const fs::path& dir, const Asset& asset) {
  std::ifstream source(asset.source, std::ios::binary);
  if (!source) return read_error(asset.source, errno != 0 ? errno : EIO);
  StreamedFile copy(dir, asset_name(asset));
  Sha256 hash;
  std::string piece(std::size_t{1} << 18, '\0');
  while (source.read(piece.data(), static_cast<std::streamsize>(piece.size())),
         source.gcount() > 0) {
    const std::string_view got(piece.data(), static_cast<std::size_t>(source.gcount()));
    hash.update(got);
    copy.append(got);
  }
  if (source.bad()) return read_error(asset.source, EIO);
  // Checked before the copy gets its name, so that a file named by a hash has that hash.
  if (hash.finish() != asset.sha256) {
    return Error{ErrorKind::usage, asset.source.string() +
                                       " has changed since this run began; restore the old file "
                                       "or generate into another folder"};
  }
  return copy.commit();
}

// The values of dataset.json that summarize all sequences.
struct SequenceSums {
  std::optional<PlacementTotals> placement;
  std::optional<std::array<double, 2>> limits_db;  // of the 8-bit images
  DisplayCounts counts;
};

// Whether the sequence's images have the limits of those before it.
bool add_images(const SequenceInfo& sequence, SequenceSums& images) {
  if (!sequence.output.png) return true;
  images.counts += sequence.png_counts;
  if (!images.limits_db) images.limits_db = sequence.png.limits_db;
  return *images.limits_db == sequence.png.limits_db;
}

Result<SequenceEntry> read_sequence(const fs::path& dir, std::uint32_t sequence,
                                    const DatasetInfo& info, SequenceSums& totals) {
  const std::string relative = layout::in_sequence(sequence, layout::kSequenceJson);
  const auto unfinished = [&] {
    return Error{ErrorKind::usage,
                 fmt::format("{}: the sequence is not finished; generate all of its pings first",
                             (dir / layout::sequence_folder(sequence)).string())};
  };
  if (!sequence_is_finished(dir, sequence)) return unfinished();
  auto hash = sha256_of_file(dir / relative);
  if (!hash) return hash.error();
  const auto own_bytes = listed_file_size(dir, relative);
  const auto manifest = read_sequence_manifest(dir, sequence);
  if (!manifest || manifest->bytes == 0 || !own_bytes) return unfinished();
  const SequenceInfo& own = manifest->info;
  const auto split = std::find(layout::kSplits.begin(), layout::kSplits.end(), own.split);
  if (own.classes != info.classes || split == layout::kSplits.end()) {
    return damaged(dir / relative,
                   "does not have the classes of the data set, or has an unknown split");
  }
  if (own.placement) {
    if (!totals.placement) totals.placement.emplace();
    add(*own.placement, *totals.placement);
  }
  if (!add_images(own, totals)) {
    return damaged(dir / relative,
                   "its limits of 8-bit images differ from those of the sequences before it");
  }
  return SequenceEntry{sequence,        own.first_ping, own.last_ping,
                       own.seed,        own.split,      manifest->bytes + *own_bytes,
                       std::move(*hash)};
}

Status check_inputs(const fs::path& dir, const DatasetInfo& info) {
  if (info.sequences.empty()) return Error{ErrorKind::bug, "a data set needs a sequence"};
  const auto work = read_file(dir / layout::kWorkJson);
  if (!work) return work.error();
  if (*work == to_json(info.identity)) return {};
  return Error{ErrorKind::usage,
               dir.string() + ": now holds the data set of another run; name another folder"};
}

// index.csv and splits/*.txt, line by line from the sequences' own files.
Result<std::vector<FileEntry>> write_index(const fs::path& dir,
                                           const std::vector<SequenceEntry>& sequences) {
  StreamedFile index(dir, "index.csv");
  StreamedFile train(dir, "splits/train.txt");
  StreamedFile val(dir, "splits/val.txt");
  StreamedFile test(dir, "splits/test.txt");
  StreamedFile* splits[] = {&train, &val, &test};
  index.append(kIndexHeader);
  for (const SequenceEntry& sequence : sequences) {
    const auto split = std::find(layout::kSplits.begin(), layout::kSplits.end(), sequence.split);
    StreamedFile& list = *splits[split - layout::kSplits.begin()];
    const Status read =
        for_each_annotated_ping(dir, sequence.sequence, [&](std::uint32_t ping, double time_s) {
          index.append(index_row(sequence.sequence, ping, time_s, sequence.split));
          list.append(layout::index_stem(sequence.sequence, ping) + "\n");
        });
    if (!read) return read.error();
  }
  std::vector<FileEntry> entries;
  for (StreamedFile* file : {&index, &train, &val, &test}) {
    auto entry = file->commit();
    if (!entry) return entry.error();
    entries.push_back(std::move(*entry));
  }
  return entries;
}

Result<std::vector<FileEntry>> write_top_level(const fs::path& dir, const DatasetInfo& info,
                                               const std::vector<SequenceEntry>& sequences) {
  std::vector<FileEntry> entries;
  const auto keep = [&](Result<FileEntry> entry) -> Status {
    if (!entry) return entry.error();
    entries.push_back(std::move(*entry));
    return {};
  };
  const std::string work = to_json(info.identity);
  entries.push_back({layout::kWorkJson, work.size(), sha256_hex(work)});
  std::uint64_t pings = 0;
  for (const SequenceEntry& sequence : sequences) pings += sequence.pings();
  Status done = keep(write_file_atomically(dir, "README.md", data_card(info, pings)));
  if (done) done = keep(write_file_atomically(dir, "scenario.yaml", info.scenario_yaml));
  std::set<std::string> copied;
  for (const Asset& asset : info.assets) {
    if (done && copied.insert(asset_name(asset)).second) done = keep(copy_asset(dir, asset));
  }
  if (!done) return done.error();
  const auto tables = write_index(dir, sequences);
  if (!tables) return tables.error();
  entries.insert(entries.end(), tables->begin(), tables->end());
  done = keep(write_coco(dir, info.identity.name, info.sequences,
                         categories_json(info.classes, info.class_kinds),
                         info.first.recording.has_value()));
  if (!done) return done.error();
  const auto by_path = [](const FileEntry& a, const FileEntry& b) { return a.path < b.path; };
  std::sort(entries.begin(), entries.end(), by_path);
  const std::string croissant = croissant_text({.publication = info.publication,
                                                .name = info.identity.name,
                                                .version = info.identity.program_version,
                                                .first = info.first,
                                                .classes = info.classes,
                                                .files = entries,
                                                .sequences = sequences.size(),
                                                .pings = pings});
  done = keep(write_file_atomically(dir, layout::kCroissantJson, croissant));
  if (!done) return done.error();
  std::sort(entries.begin(), entries.end(), by_path);
  return entries;
}

DatasetManifest manifest_of(const DatasetInfo& info, std::vector<SequenceEntry> sequences,
                            const SequenceSums& totals, const std::vector<FileEntry>& files) {
  DatasetManifest manifest;
  manifest.version = 1;
  manifest.identity = info.identity;
  manifest.classes = info.classes;
  manifest.class_kinds = info.class_kinds;
  manifest.sequences = std::move(sequences);
  manifest.failed = info.failed;
  manifest.placement = totals.placement;
  if (totals.limits_db) {
    manifest.png = info.first.png;
    manifest.png->limits_db = *totals.limits_db;
    manifest.png_counts = totals.counts;
  }
  for (const SequenceEntry& entry : manifest.sequences) manifest.bytes += entry.bytes;
  for (const FileEntry& entry : files) manifest.bytes += entry.bytes;
  return manifest;
}

std::optional<DatasetManifest> manifest_in(const fs::path& dir) {
  const auto head = parse_manifest_file(dir / layout::kDatasetJson, [](const FileEntry&) {});
  return head ? read_dataset_head(*head) : std::nullopt;
}

// The number of sequences that are finished or cannot be made.
template <class Dataset>
std::size_t listed(const Dataset& dataset) {
  return dataset.sequences.size() + dataset.failed.size();
}

// While top-level files are renewed for more sequences, the old dataset.sha256 must not exist.
Status break_outgrown_seal(const fs::path& dir, const DatasetInfo& info) {
  if (!listed_file_size(dir, layout::kDatasetJson)) return {};
  const auto old = manifest_in(dir);
  if (old && listed(*old) == listed(info)) return {};
  const fs::path seal = dir / layout::kDatasetSha256;
  if (::unlink(seal.c_str()) != 0 && errno != ENOENT) return write_error(seal, errno);
  return {};
}

Status write_provenance(const fs::path& dir, const DatasetInfo& info) {
  const auto written =
      write_file_atomically(dir, layout::kProvenanceJson,
                            json_text({{"host", info.host},
                                       {"wall_seconds", number_or_null(info.wall_seconds)},
                                       {"threads", info.threads}}));
  return written ? Status() : Status(written.error());
}

// Returns a finished data set of the same run that has all of these sequences and more, and is
// therefore newer.
std::optional<DatasetManifest> outgrown_by(const fs::path& dir, const DatasetInfo& info) {
  if (!is_sealed(dir)) return std::nullopt;
  auto manifest = manifest_in(dir);
  if (!manifest || listed(*manifest) <= listed(info)) return std::nullopt;
  std::set<std::uint32_t> numbers;
  for (const SequenceEntry& entry : manifest->sequences) numbers.insert(entry.sequence);
  const bool has_all =
      std::all_of(info.sequences.begin(), info.sequences.end(),
                  [&](std::uint32_t sequence) { return numbers.contains(sequence); });
  return has_all ? std::move(manifest) : std::nullopt;
}

// Keeps the files of further sequences of this run, which another process may have started.
void remove_own_work(const fs::path& dir, const DatasetInfo& info) {
  std::vector<std::uint32_t> numbers = info.sequences;
  for (const SequenceFailure& failure : info.failed) numbers.push_back(failure.sequence);
  if (info.sequences_in_all <= numbers.size()) remove_temporary_files(dir);
  remove_work_of(dir, numbers);
}

Status seal(const fs::path& dir, const DatasetManifest& manifest,
            const std::vector<FileEntry>& entries) {
  const auto written =
      write_file_atomically(dir, layout::kDatasetJson, json_text(dataset_json(manifest, entries)));
  if (!written) return written.error();
  const auto sealed = write_file_atomically(dir, layout::kDatasetSha256,
                                            written->sha256 + "  " + layout::kDatasetJson + "\n");
  return sealed ? Status() : Status(sealed.error());
}

Result<DatasetManifest> write_dataset(const fs::path& dir, const DatasetInfo& info) {
  const FolderLock lock(dir);
  if (const Status fit = check_inputs(dir, info); !fit) return fit.error();
  if (auto newer = outgrown_by(dir, info)) {
    for (const std::uint32_t sequence : info.sequences) remove_pieces(dir, sequence);
    remove_own_work(dir, info);
    return std::move(*newer);
  }
  std::vector<SequenceEntry> sequences;
  SequenceSums totals;
  for (const std::uint32_t sequence : info.sequences) {
    auto entry = read_sequence(dir, sequence, info, totals);
    if (!entry) return entry.error();
    sequences.push_back(std::move(*entry));
    // Temporary files of an interrupted finishing step.
    remove_pieces(dir, sequence);
  }
  std::vector<std::string> assets;
  for (const Asset& asset : info.assets) assets.push_back(asset_name(asset));
  if (const Status planned = plan_top_level(dir, assets); !planned) return planned.error();
  if (const Status broken = break_outgrown_seal(dir, info); !broken) return broken.error();

  const auto entries = write_top_level(dir, info, sequences);
  if (!entries) return entries.error();
  if (const Status written = write_provenance(dir, info); !written) return written.error();
  DatasetManifest manifest = manifest_of(info, std::move(sequences), totals, *entries);
  if (const Status sealed = seal(dir, manifest, *entries); !sealed) return sealed.error();
  remove_own_work(dir, info);
  return manifest;
}

}  // namespace

Result<DatasetManifest> finish_dataset(const fs::path& dir, const DatasetInfo& info) {
  return without_exceptions("finishing " + dir.string(), [&] { return write_dataset(dir, info); });
}

}  // namespace ensonify
