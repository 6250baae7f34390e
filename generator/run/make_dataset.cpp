#include "run/make_dataset.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <functional>

#include "core/counted.h"
#include "dataset/write_ping.h"
#include "formats/sha256.h"
#include "run/display_limits.h"
#include "run/program.h"
#include "run/terminal.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

Result<std::vector<Asset>> hash_assets(const Scenario& scenario, FileHashes& hashes) {
  std::vector<Asset> assets;
  for (const fs::path& file : input_files(scenario)) {
    Result<std::string> hash = hashes.of(file);
    if (!hash) return hash.error();
    assets.push_back({*hash, file.extension().string(), file});
  }
  return assets;
}

std::string name_in_dataset(const Asset& asset) {
  return "assets/" + asset.sha256 + asset.extension;
}

// The resolved text in its form in a data set, with input files named by the hash of their content.
std::string resolved_text(const Scenario& scenario, const std::vector<Asset>& assets) {
  return to_yaml(scenario, [&](const fs::path& file) {
    for (const Asset& asset : assets) {
      if (asset.source == file) return name_in_dataset(asset);
    }
    return file.string();
  });
}

// What the realizations of a scenario have in common. Keys are left out if they are known not to
// change an echo, so that a forgotten key separates scenes instead of mixing them.
std::string scene_text(Scenario scenario, const std::vector<Asset>& assets) {
  const Scenario none;
  scenario.name = none.name;
  scenario.seed = none.seed;
  scenario.speckle_seed = none.speckle_seed;
  scenario.sequences = none.sequences;
  scenario.trajectory.pings = none.trajectory.pings;
  scenario.output = scenario.rig_output = none.output;
  scenario.splits = none.splits;
  scenario.dataset = none.dataset;
  return resolved_text(scenario, assets);
}

WorkIdentity identity_of(const SequenceWorlds& worlds, const DatasetWork& work,
                         const Numerics& numerics) {
  const Session& session = worlds.first();
  // More sequences only extend the same work; the first ones do not change.
  Scenario without_count = session.scenario;
  without_count.sequences = 1;
  WorkIdentity identity;
  identity.name = session.scenario.name;
  identity.scenario_sha256 = sha256_hex(resolved_text(without_count, work.assets));
  identity.seed = session.scenario.seed;
  identity.first_ping = work.first.first_ping;
  identity.last_ping = work.first.last_ping;
  identity.program_version = program_version();
  identity.program_commit = program_commit();
  identity.backend = numerics.backend_name;
  identity.simd = numerics_name(numerics.simd);
  identity.embree_isa = worlds.first_tracer().instruction_set();
  return identity;
}

Result<PingRange> sequences_of(const std::optional<PingRange>& asked, const Scenario& scenario) {
  if (!asked) return PingRange{0, scenario.sequences};
  const auto [first, last] = *asked;
  if (first < last && last <= scenario.sequences) return *asked;
  return Error{ErrorKind::usage,
               fmt::format("--sequences {}:{}: the scenario has sequences 0 to {}; expected A:B "
                           "with 0 <= A < B <= {}",
                           first, last, scenario.sequences - 1, scenario.sequences)};
}

// Indents further lines of an error below its first.
std::string indented(std::string text) {
  for (auto at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 1)) {
    text.insert(at + 1, "    ");
  }
  return text;
}

}  // namespace

void add_scene_keys(const Scenario& scenario, const std::vector<Asset>& assets,
                    SequenceInfo& info) {
  info.scenario_sha256 = sha256_hex(scene_text(scenario, assets));
  // As sampled, not as a distribution. The seed also keys what no text shows, such as textures.
  Scenario sampled = scenario;
  sampled.drawn_sections.reset();
  std::string text = scene_text(std::move(sampled), assets);
  if (varies_by_sequence(scenario)) {
    text += fmt::format("\nseed {} sequence {}\n", info.seed, info.sequence);
  }
  info.scene_sha256 = sha256_hex(text);
}

Result<Numerics> settled_numerics(BackendChoice backend, SimdLevel simd, bool quiet) {
  Result<Numerics> numerics = settle_backend(backend, simd);
  if (numerics) numerics->tables = std::make_shared<TableCache>();
  if (numerics && numerics->backend == BackendChoice::cuda && !quiet) {
    tell("backend: {}\n", numerics->backend_name);
  }
  if (numerics && !numerics->no_device.empty() && !quiet) {
    tell("backend: cpu, since there is no device ({})\n", numerics->no_device);
  }
  return numerics;
}

Result<std::string> FileHashes::of(const fs::path& file) {
  const std::lock_guard lock(mutex_);
  const auto known = known_.find(file);
  if (known != known_.end()) return known->second;
  Result<std::string> hash = sha256_of_file(file);
  if (hash) known_.emplace(file, *hash);
  return hash;
}

Result<DatasetWork> settle_dataset(const SequenceWorlds& worlds,
                                   const std::optional<PingRange>& pings,
                                   const std::optional<PingRange>& sequences,
                                   const Numerics& numerics, FileHashes& hashes) {
  const Scenario& scenario = worlds.first().scenario;
  const Result<PingRange> asked = sequences_of(sequences, scenario);
  if (!asked) return asked.error();
  Result<SequenceInfo> first = worlds.info(worlds.first_sequence(), pings);
  if (!first) return first.error();
  Result<std::vector<Asset>> assets = hash_assets(scenario, hashes);
  if (!assets) return assets.error();
  DatasetWork work{
      std::move(*first), scenario.sequences, *asked, pings, std::move(*assets), {}, {}, {}};
  work.identity = identity_of(worlds, work, numerics);
  work.scenario_yaml = resolved_text(scenario, work.assets);
  return work;
}

Status settle_display(const fs::path& dir, const SequenceWorlds& worlds, const Numerics& numerics,
                      const Workers& workers, DatasetWork& work, SharedParts& first) {
  const SequenceInfo& info = work.first;
  const bool makes_ping_zero = worlds.first_sequence() == 0 && work.asked.first == 0 &&
                               work.asked_count() > 0 && info.first_ping == 0 &&
                               !info.output.statistics && !ping_is_finished(dir, 0, 0, info);
  WorldsFrom probed = worlds_from_first(worlds);
  probed.world = [&](std::uint32_t sequence) {
    Result<ReadyWorld> world = worlds.world(sequence);
    const bool is_made = sequence >= work.asked.first && sequence < work.asked.second &&
                         !sequence_is_finished(dir, sequence);
    if (world && is_made) worlds.keep(sequence, *world);
    return world;
  };
  const auto limits_db = display_limits_db(worlds.first().scenario.output, probed, numerics,
                                           workers, &first, makes_ping_zero);
  if (!limits_db) return limits_db.error();
  work.limits_db = *limits_db;
  return {};
}

PublicationInfo publication_of(const Scenario& scenario) {
  const auto& [license, creator, citation, url, published] = scenario.dataset;
  return {license, creator, citation, url, published};
}

Result<DatasetManifest> finish_work(const fs::path& dir, const SequenceWorlds& worlds,
                                    DatasetWork work, int threads, double wall_seconds) {
  DatasetInfo dataset;
  dataset.sequences_in_all = work.sequences;
  for (SequenceFailure& failure : failures_of(dir, work)) {
    if (!sequence_is_finished(dir, failure.sequence)) dataset.failed.push_back(std::move(failure));
  }
  auto failed = dataset.failed.begin();
  for (std::uint32_t sequence = 0; sequence < work.sequences; ++sequence) {
    if (failed != dataset.failed.end() && failed->sequence == sequence) {
      ++failed;
    } else if (sequence_is_finished(dir, sequence)) {
      dataset.sequences.push_back(sequence);
    } else if (sequence >= work.asked.first && sequence < work.asked.second) {
      return Error{ErrorKind::io,
                   fmt::format("{}: sequence {} was finished and is now damaged; check what else "
                               "changes the folder, then repeat the command",
                               dir.string(), sequence)};
    }
  }
  if (dataset.sequences.empty()) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: no data set was made: {}", dir.string(),
                             failures_text(dataset.failed, dataset.failed.size()))};
  }
  dataset.identity = std::move(work.identity);
  dataset.scenario_yaml = std::move(work.scenario_yaml);
  dataset.first = std::move(work.first);
  dataset.classes = worlds.first().world.classes;
  dataset.class_kinds = worlds.first().scenario.class_kinds;
  dataset.assets = std::move(work.assets);
  dataset.publication = publication_of(worlds.first().scenario);
  dataset.host = host_name();
  dataset.threads = threads;
  dataset.wall_seconds = wall_seconds;
  return finish_dataset(dir, dataset);
}

std::vector<SequenceFailure> failures_of(const fs::path& dir, const DatasetWork& work) {
  std::vector<SequenceFailure> failed;
  for (auto& [sequence, error] : failures_in(dir)) {
    if (sequence < work.sequences) failed.push_back({sequence, error});
  }
  return failed;
}

std::string portable_text(std::string text, std::span<const Asset> assets) {
  // The longest paths come first, because a path may begin with another one.
  std::map<std::pair<std::size_t, std::string>, std::string, std::greater<>> names;
  for (const Asset& asset : assets) {
    const std::string path = asset.source.string();
    names[{path.size(), path}] = name_in_dataset(asset);
  }
  for (const auto& [path, name] : names) {
    for (auto at = text.find(path.second); at != std::string::npos;
         at = text.find(path.second, at + name.size())) {
      text.replace(at, path.second.size(), name);
    }
  }
  return text;
}

std::string failures_text(std::span<const SequenceFailure> failed, std::uint64_t sequences) {
  constexpr std::size_t kMostNamed = 10;
  std::string text =
      fmt::format("{} of {} could not be made", failed.size(), counted(sequences, "sequence"));
  const std::size_t named = std::min(failed.size(), kMostNamed);
  for (const auto& [sequence, error] : failed.first(named)) {
    text += fmt::format("\n  sequence {}: {}", sequence, indented(error));
  }
  if (failed.size() > named) text += fmt::format("\n  and {} more", failed.size() - named);
  return text;
}

std::string host_name() {
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
}

}  // namespace ensonify
