// Makes one data set from prepared scenarios, for `generate` and for each run of a sweep.
//
//   settled_numerics
//   FileHashes     of input files, each read once
//   add_scene_keys  what realizations have in common, for output.statistics
//   DatasetWork  settle_dataset   everything known, nothing written
//   settle_display ... and the limits of 8-bit images
//   publication_of  finish_work    the last step
//   failures_of  portable_text  failures_text   the sequences that cannot be made
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dataset/finish.h"
#include "dataset/work_folder.h"
#include "ping/pipeline.h"
#include "ping/tables.h"
#include "run/sequence_worlds.h"

namespace ensonify {

// Calls settle_backend and reports a device, because `auto` may have chosen it.
Result<Numerics> settled_numerics(BackendChoice backend, SimdLevel simd, bool quiet);

class FileHashes {
 public:
  // Returns the SHA-256; may be called from several threads at once. Errors (io).
  Result<std::string> of(const std::filesystem::path& file);

 private:
  std::mutex mutex_;
  std::map<std::filesystem::path, std::string> known_;
};

// Sets the keys of `info`: realizations of one scene have the same scene_sha256, worlds of one
// scenario the same scenario_sha256. `scenario`: as sampled for the sequence.
void add_scene_keys(const Scenario& scenario, const std::vector<Asset>& assets, SequenceInfo& info);

struct DatasetWork {
  SequenceInfo first;              // of the first sequence that can be made
  std::uint32_t sequences = 0;     // of the scenario
  PingRange asked;                 // sequences that are to be made
  std::optional<PingRange> pings;  // of each sequence; absent: all
  std::vector<Asset> assets;
  WorkIdentity identity;
  std::string scenario_yaml;
  std::array<double, 2> limits_db = Display{}.limits_db;  // of 8-bit images; see settle_display

  std::uint32_t asked_count() const { return asked.second - asked.first; }
};

// `pings`, `sequences`: ranges [first, last); absent: all. Errors: usage (the scenario does not
// have the range), io (an input file cannot be read).
Result<DatasetWork> settle_dataset(const SequenceWorlds& worlds,
                                   const std::optional<PingRange>& pings,
                                   const std::optional<PingRange>& sequences,
                                   const Numerics& numerics, FileHashes& hashes);

// Computes work.limits_db. `first`: known parts of the first world, to which new parts are
// added, and ping 0 if `dir` does not have it. Errors: those of display_limits_db.
Status settle_display(const std::filesystem::path& dir, const SequenceWorlds& worlds,
                      const Numerics& numerics, const Workers& workers, DatasetWork& work,
                      SharedParts& first);

// What the author of the scenario states about the data set.
PublicationInfo publication_of(const Scenario& scenario);

// Writes the top level of the data set when the requested sequences are made or cannot be made; it
// includes other finished sequences. Errors: those of finish_dataset; usage: there is no sequence;
// io: a requested sequence is damaged.
Result<DatasetManifest> finish_work(const std::filesystem::path& dir, const SequenceWorlds& worlds,
                                    DatasetWork work, int threads, double wall_seconds);

// The failures that `dir` has a record of, in ascending order.
std::vector<SequenceFailure> failures_of(const std::filesystem::path& dir, const DatasetWork& work);

// The text with the names of input files in the data set, which is the same on every machine.
std::string portable_text(std::string text, std::span<const Asset> assets);

// `3 of 100 sequences could not be made`, followed by the first of them with their errors, one per
// line.
std::string failures_text(std::span<const SequenceFailure> failed, std::uint64_t sequences);

std::string host_name();

}  // namespace ensonify
