// One data set from scenarios that are ready: what `generate` and each run of a sweep do.
//
//   settled_numerics
//   FileHashes     of input files, each read once
//   DatasetWork  settle_dataset   everything known, nothing written
//   finish_work    the last step
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/sequence_worlds.h"
#include "app/tables.h"
#include "dataset/finish.h"

namespace ensonify {

// settle_backend; a device is said aloud, since `auto` may have taken it.
Result<Numerics> settled_numerics(BackendChoice backend, SimdLevel simd, bool quiet);

class FileHashes {
 public:
  // SHA-256; from several threads at once. Errors (io).
  Result<std::string> of(const std::filesystem::path& file);

 private:
  std::mutex mutex_;
  std::map<std::filesystem::path, std::string> known_;
};

struct DatasetWork {
  std::vector<SequenceInfo> infos;  // of all sequences
  PingRange asked;                  // the sequences that are to be made
  std::vector<Asset> assets;
  WorkIdentity identity;
  std::string scenario_yaml;

  std::span<const SequenceInfo> sequences() const {
    return std::span(infos).subspan(asked.first, asked.second - asked.first);
  }
};

// `pings`, `sequences`: ranges [first, last); absent: all. Errors (usage): a range that the
// scenario has not, draws of a sequence that make no valid scenario; io: an input file cannot be
// read.
Result<DatasetWork> settle_dataset(const SequenceWorlds& worlds,
                                   const std::optional<PingRange>& pings,
                                   const std::optional<PingRange>& sequences,
                                   const Numerics& numerics, FileHashes& hashes,
                                   const Workers& workers);

// The top level of the data set, once those asked for are made; others are in it that are whole.
// Errors: those of finish_dataset; io: one of those asked for is not whole.
Status finish_work(const std::filesystem::path& dir, const SequenceWorlds& worlds, DatasetWork work,
                   int threads, double wall_seconds);

std::string host_name();

}  // namespace ensonify
