#include "run/disk_room.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <system_error>

#include "core/moments.h"
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
// A run that needs at most this share of the free space is not measured.
constexpr double kSafeShare = 0.25;
// On average, the last block of a file is half empty.
constexpr double kUnusedBytesPerFile = 2048;
// One ping or sequence is made for every kPerProbe of them, at most kMostProbes, to measure the
// size of all.
constexpr std::uint64_t kPerProbe = 20, kMostProbes = 3;

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

double top_level_bytes(const Session& session, const Remaining& remaining) {
  if (remaining.listed_sequences == 0) return 0;
  const std::string text = to_yaml(session.scenario, [](const fs::path& f) { return f.string(); });
  return kTopBytes + croissant_bytes(session) + static_cast<double>(text.size()) + input_bytes(session.scenario) +
         kTopBytesPerSequence * static_cast<double>(remaining.listed_sequences);
}

// Bytes of temporary files, which exist only while the run is in progress, and the unused space in
// blocks.
double passing_bytes(const Measured& measured, const Session& session, const Remaining& remaining,
                     std::uint64_t sequences_at_once) {
  const auto pings = static_cast<double>(remaining.pings);
  const auto at_once = static_cast<double>(sequences_at_once);
  const double longest = static_cast<double>(session.ping_times_s.size());
  const Cost all = estimate_cost(session, 0);
  const double share = pings / static_cast<double>(all.pings);
  double bytes = pings * measured.record + share * unused_bytes(all.files + all.pings) +
                 std::min(pings, at_once * longest) * measured.piece;
  if (session.scenario.output.selection.statistics) {
    bytes += at_once * static_cast<double>(ping_size(session).pixels * kMoments * sizeof(double));
  }
  return bytes;
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

Remaining all_of(const MeasureJob& job) {
  const std::uint64_t sequences = job.count(), pings = sequences * job.pings_each;
  return {pings, sequences, pings, sequences, pings};
}

double disk_bytes(const Measured& measured, const Session& session, const Remaining& remaining) {
  const double of_sequence = measured.sequence_bytes + scene_file_sizes(session).file_bytes;
  return static_cast<double>(remaining.pings) * (measured.files - measured.piece) +
         static_cast<double>(remaining.sequence_pings) *
             (measured.piece + measured.sequence_lines) +
         static_cast<double>(remaining.sequences) * of_sequence +
         static_cast<double>(remaining.listed_pings) * measured.dataset_lines +
         top_level_bytes(session, remaining);
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

std::uint32_t probes(std::uint64_t count) {
  return static_cast<std::uint32_t>(std::clamp<std::uint64_t>(count / kPerProbe, 1, kMostProbes));
}

// Sequences count as having as many pings as the first.
Remaining remaining_of(const GenerateOptions& options, const SequenceWorlds& worlds,
                       const DatasetWork& work, bool continues) {
  const std::uint64_t each = work.first.last_ping - work.first.first_ping;
  Remaining rest;
  rest.sequences = rest.listed_sequences = work.asked_count();
  rest.pings = rest.sequence_pings = rest.listed_pings = rest.sequences * each;
  if (continues) {
    for (const std::uint32_t sequence : sequence_numbers(options.output)) {
      if (sequence < work.asked.first || sequence >= work.asked.second) continue;
      if (!sequence_is_finished(options.output, sequence)) continue;
      --rest.sequences;
      rest.sequence_pings -= each;
    }
    const std::uint64_t found = ping_totals(options.output, worlds, work).found;
    rest.pings -= std::min(rest.pings, found);
  }
  if (options.shard) rest.listed_sequences = rest.listed_pings = 0;
  return rest;
}

MeasureJob job_of(const SequenceWorlds& worlds, const DatasetWork& work, const Numerics& numerics,
                  int threads) {
  return {work.asked,
          work.pings,
          work.first.last_ping - work.first.first_ping,
          worlds.vary(),
          [&worlds](std::uint32_t sequence) { return worlds.world(sequence); },
          numerics,
          threads};
}

// The size of all remaining files, from an upper bound for the echoes of a ping and from typical
// images. Files of a sequence do not shrink with its pings.
double roughly(const Session& session, const Remaining& rest) {
  const EchoCounts most = most_echoes(session);
  const Cost all = estimate_cost(session, most.surface + most.coherent);
  const double share =
      std::max(static_cast<double>(rest.sequence_pings) / static_cast<double>(all.pings),
               static_cast<double>(rest.sequences) / session.scenario.sequences);
  return share * (static_cast<double>(all.disk_bytes) + unused_bytes(all.files)) +
         input_bytes(session.scenario);
}

}  // namespace

Status room_for_work(const GenerateOptions& options, const SequenceWorlds& worlds,
                     const DatasetWork& work, const Numerics& numerics, int threads,
                     SharedParts& first) {
  if (options.ignore_free_space || work.asked_count() == 0) return {};
  std::optional<std::uint64_t> free = free_bytes(options.output);
  if (!free) return {};
  const Session& session = worlds.first();
  const double most = roughly(session, remaining_of(options, worlds, work, false));
  if (most < kSafeShare * static_cast<double>(*free)) return {};
  const bool is_same = continues(options.output, work);
  if (!is_same && !options.overwrite && holds_work(options.output)) return {};  // is refused anyway
  const bool is_emptied = options.overwrite && (!is_same || is_sealed(options.output));
  const Remaining rest = remaining_of(options, worlds, work, is_same && !is_emptied);
  if (rest.sequences == 0) return {};
  if (is_emptied) *free += static_cast<std::uint64_t>(bytes_in(options.output));
  MeasureJob job = job_of(worlds, work, numerics, threads);
  job.first = worlds.first_sequence();
  job.most_pings = probes(rest.pings);
  job.most_sequences = probes(rest.sequences);
  const Result<Measured> measured = measure_pings(job, first);
  if (!measured) return measured.error();
  const auto at_once = static_cast<std::uint64_t>(
      sequences_under_way(threads, session.ping_times_s.size(), rest.sequences, worlds.vary()));
  return room_for_bytes(
      options.output,
      disk_bytes(*measured, session, rest) + passing_bytes(*measured, session, rest, at_once),
      free);
}

namespace {

// The measured size of a data set divided by the estimate of run_cost. 1 if its first world cannot
// be built, because making the run reports this error.
double measured_share(const Sweep& sweep, const SweepRun& run, const Numerics& numerics,
                      int threads) {
  Result<Session> session =
      drawn_session({[&](SequenceDraw draw) { return scenario_of(sweep.file, run.point, draw); },
                     [](Scenario scenario, std::uint32_t sequence) {
                       return prepare_session(std::move(scenario), sequence);
                     }},
                    0);
  if (!session) return 1;
  const auto pings = static_cast<std::uint32_t>(session->ping_times_s.size());
  const std::uint32_t sequences = session->scenario.sequences;
  ReadyWorld world;
  world.session = std::make_shared<const Session>(std::move(*session));
  world.tracer = std::make_shared<const Tracer>(world.session->world);
  MeasureJob job{
      {0, sequences}, {}, pings, false, [&](std::uint32_t) { return world; }, numerics, threads};
  job.most_pings = probes(pings);
  job.most_sequences = 1;
  SharedParts first;
  const Result<Measured> measured = measure_pings(job, first);
  if (!measured) return 1;
  return disk_bytes(*measured, *world.session, all_of(job)) /
         static_cast<double>(run.cost.disk_bytes);
}

}  // namespace

Status room_for_runs(const SweepOptions& options, const Sweep& sweep,
                     const std::vector<std::size_t>& runs, const Numerics& numerics, int threads) {
  const auto free = free_bytes(options.output);
  std::vector<const SweepRun*> missing;
  double needed = 0, unused = 0, there = 0;
  for (const std::size_t i : runs) {
    const SweepRun& run = sweep.runs[i];
    if (run_is_done(options.output, run.id)) continue;
    missing.push_back(&run);
    needed += static_cast<double>(run.cost.disk_bytes);
    unused += unused_bytes(run.cost.files + run.cost.pings);  // with a record of each ping
  }
  const bool is_enough = !free || needed + unused < kSafeShare * static_cast<double>(*free);
  if (options.ignore_free_space || missing.empty() || is_enough) return {};
  for (const SweepRun* run : missing) there += bytes_in(options.output / run_folder(run->id));
  const double share = measured_share(sweep, *missing.front(), numerics, threads);
  return room_for_bytes(options.output, needed * share + unused - there, free);
}

}  // namespace ensonify
