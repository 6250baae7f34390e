#include "run/disk_room.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "dataset/catalogue.h"
#include "dataset/croissant.h"
#include "dataset/finish.h"
#include "dataset/layout.h"
#include "dataset/work.h"
#include "formats/files.h"
#include "ping/prepare_session.h"
#include "ping/scene_files.h"
#include "ping/sequence_info.h"
#include "run/cost.h"
#include "run/make_dataset.h"
#include "run/make_sequences.h"
#include "run/memory.h"
#include "sweep/folder.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// Bytes of README.md, work.json and the heads of dataset.json and coco.json, and of a line of
// dataset.json.
constexpr double kTopBytes = 7'300, kTopBytesPerSequence = 240;
// On average, the last block of a file is half empty.
constexpr double kUnusedBytesPerFile = 2048;

double unused_bytes(std::uint64_t files) {
  return kUnusedBytesPerFile * static_cast<double>(files);
}

double input_bytes(const Scenario& scenario) {
  double bytes = 0;
  for (const fs::path& file : input_files(scenario)) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(file, error);
    if (!error) bytes += static_cast<double>(size);
  }
  return bytes;
}

double croissant_bytes(const Session& session) {
  const auto pings = static_cast<std::uint32_t>(session.ping_times_s.size());
  const SequenceInfo first = sequence_info(session, 0, 0, pings);
  std::vector<FileEntry> files;
  for (const CatalogueRow& row : catalogue()) {
    if (row.scope == FileScope::dataset) files.push_back({row.file, 0, std::string(64, '0')});
  }
  const PublicationInfo publication = publication_of(session.scenario);
  const std::string text = croissant_text({.publication = publication,
                                           .name = session.scenario.name,
                                           .version = session.scenario.name,
                                           .first = first,
                                           .classes = first.classes,
                                           .files = files,
                                           .sequences = session.scenario.sequences,
                                           .pings = pings});
  return static_cast<double>(text.size());
}

double top_level_bytes(const Session& session) {
  const std::string text = to_yaml(session.scenario, [](const fs::path& f) { return f.string(); });
  return kTopBytes + croissant_bytes(session) + static_cast<double>(text.size()) +
         input_bytes(session.scenario) + kTopBytesPerSequence * session.scenario.sequences;
}

}  // namespace

fs::path folder_there(const fs::path& folder) {
  std::error_code error;
  fs::path there = fs::absolute(folder.empty() ? fs::path(".") : folder, error);
  while (!error && !fs::exists(there, error) && there.has_relative_path()) {
    there = there.parent_path();
  }
  return there;
}

std::optional<std::uint64_t> free_bytes(const fs::path& folder) {
  std::error_code error;
  const fs::space_info space = fs::space(folder_there(folder), error);
  if (error) return std::nullopt;
  return space.available;
}

double disk_bytes(const Measured& measured, const Session& session) {
  const double sequences = session.scenario.sequences;
  const double pings = sequences * static_cast<double>(session.ping_times_s.size());
  return pings * (measured.files + measured.sequence_lines + measured.dataset_lines) +
         sequences * (measured.sequence_bytes + scene_file_sizes(session).file_bytes) +
         top_level_bytes(session);
}

Status room_for_bytes(const fs::path& folder, double needed,
                      const std::optional<std::uint64_t>& free) {
  if (!free || needed <= static_cast<double>(*free)) return {};
  return Error{ErrorKind::io,
               fmt::format("{}: the data needs about {} of disk space, but only {} is free; free "
                           "some space, choose a folder on another disk, select fewer files (the "
                           "scenario's `output`), or give --ignore-free-space",
                           folder.string(), bytes_text(static_cast<std::uint64_t>(needed)),
                           bytes_text(*free))};
}

namespace {

// Whether the folder holds this work, whose existing files are then not made again.
bool continues(const fs::path& folder, const DatasetWork& work) {
  const auto text = read_file(folder / layout::kWorkJson, kMaxManifestBytes);
  return text && *text == to_json(work.identity);
}

bool holds_work(const fs::path& folder) {
  return listed_file_size(folder, layout::kWorkJson).has_value() ||
         listed_file_size(folder, layout::kDatasetJson).has_value();
}

// The size of all files in a folder.
double bytes_in(const fs::path& folder) {
  const auto files = files_below(folder);
  double bytes = 0;
  if (!files) return 0;
  for (const std::string& file : *files) {
    bytes += static_cast<double>(listed_file_size(folder, file).value_or(0));
  }
  return bytes;
}

// The missing parts of a data set.
struct Remaining {
  std::uint64_t pings = 0;      // to be made
  std::uint64_t sequences = 0;  // to be finished
};

// Sequences count as having as many pings as the first.
Remaining remaining_of(const GenerateOptions& options, const SequenceWorlds& worlds,
                       const DatasetWork& work, bool continues) {
  Remaining rest;
  rest.sequences = work.asked_count();
  rest.pings = rest.sequences * (work.first.last_ping - work.first.first_ping);
  if (!continues) return rest;
  for (const std::uint32_t sequence : sequence_numbers(options.output)) {
    if (sequence < work.asked.first || sequence >= work.asked.second) continue;
    rest.sequences -= sequence_is_finished(options.output, sequence);
  }
  const std::uint64_t found = ping_totals(options.output, worlds, work).found;
  rest.pings -= std::min(rest.pings, found);
  return rest;
}

// From the table of outputs, which knows how well typical images are compressed. Only lists of
// echoes need a look at the scene: their number is traced.
double needed_bytes(const SequenceWorlds& worlds, const Remaining& rest) {
  const Session& session = worlds.first();
  const OutputSelection& output = session.scenario.output.selection;
  EchoCounts echoes;
  if (output.points || output.scatterers || output.elevation) {
    echoes = count_echoes(session, worlds.first_tracer());
  }
  const std::uint64_t count = echoes.surface + echoes.coherent;
  const Cost all = estimate_cost(session, count);
  const std::uint64_t files = (all.files + all.pings) * rest.pings / all.pings;
  return estimated_bytes(session, count, rest.pings, rest.sequences) + unused_bytes(files) +
         input_bytes(session.scenario);
}

}  // namespace

Status room_for_work(const GenerateOptions& options, const SequenceWorlds& worlds,
                     const DatasetWork& work, double& needed) {
  if (options.ignore_free_space || work.asked_count() == 0) return {};
  std::optional<std::uint64_t> free = free_bytes(options.output);
  if (!free) return {};
  const bool is_same = continues(options.output, work);
  if (!is_same && !options.overwrite && holds_work(options.output)) return {};  // is refused anyway
  const bool is_emptied = options.overwrite && (!is_same || is_sealed(options.output));
  const Remaining rest = remaining_of(options, worlds, work, is_same && !is_emptied);
  if (rest.sequences == 0) return {};
  if (is_emptied) *free += static_cast<std::uint64_t>(bytes_in(options.output));
  needed += needed_bytes(worlds, rest);
  return room_for_bytes(options.output, needed, free);
}

Status room_for_runs(const SweepOptions& options, const Sweep& sweep,
                     const std::vector<std::size_t>& runs) {
  if (options.ignore_free_space) return {};
  double needed = 0;
  for (const std::size_t i : runs) {
    const SweepRun& run = sweep.runs[i];
    if (run_is_done(options.output, run.id)) continue;
    // With a record of each ping.
    needed += static_cast<double>(run.cost.disk_bytes) +
              unused_bytes(run.cost.files + run.cost.pings) -
              bytes_in(options.output / run_folder(run.id));
  }
  return room_for_bytes(options.output, needed, free_bytes(options.output));
}

}  // namespace ensonify
