// The manifests of a data set as structures; manifest_json.h writes and reads them.
//
//   SequenceManifest                 sequence.json without its list of files
//   WorkIdentity                     work.json
//   SequenceEntry  SequenceFailure  DatasetManifest   dataset.json without its list of files
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/ping.h"

namespace ensonify {

// A reader fills the parts of `info` that the file has: of `output` these are png, layers,
// channels, front, packed and statistics.
struct SequenceManifest {
  SequenceInfo info;
  std::vector<std::string> each_ping;  // templates of a ping's files (layout.h)
  bool has_arrays = false;             // of packed pings
  std::vector<std::string> arrays;     // ... the files that hold all of them
  std::uint64_t realisations = 0;      // of statistics; 0: none
  std::vector<std::string> statistics;  // ... the files
  std::uint64_t bytes = 0;             // of all files together
  std::string fault;                   // when read: the first member of a wrong kind; empty: none
};

// The scenario and program that made a data set.
struct WorkIdentity {
  std::string name;             // of the scenario
  std::string scenario_sha256;  // of the resolved scenario without `sequences`, which may grow
  std::uint64_t seed = 0;
  std::uint32_t first_ping = 0, last_ping = 0;  // [first, last)
  std::string program_version, program_commit;
  std::string backend, simd, embree_isa;
};

struct SequenceEntry {
  std::uint32_t sequence = 0;
  std::uint32_t first_ping = 0, last_ping = 0;  // [first, last)
  std::uint64_t seed = 0;
  std::string split;        // train, val or test
  std::uint64_t bytes = 0;  // of its files and its sequence.json
  std::string sha256;       // of its sequence.json

  std::uint64_t pings() const { return std::uint64_t{last_ping} - first_ping; }
};

// A sequence of the scenario that cannot be made.
struct SequenceFailure {
  std::uint32_t sequence = 0;
  std::string error;  // without places, the same on every machine
};

// Sums over the sequences of a data set in which objects are placed at random.
struct PlacementTotals {
  std::uint64_t sequences = 0;
  std::uint64_t redrawn = 0;  // of the sequences
  std::uint64_t redraws = 0;
  std::uint64_t left_out = 0;         // objects
  std::vector<PlacedClass> classes;  // sorted by name
};
void add(const Placement& placement, PlacementTotals& totals);

struct DatasetManifest {
  std::uint64_t version = 0;
  WorkIdentity identity;             // but for its pings
  std::vector<std::string> classes;  // class id k is classes[k - 1]
  std::vector<ClassKind> class_kinds;  // of each
  std::uint64_t bytes = 0;           // of all files that manifests list
  std::vector<SequenceEntry> sequences;
  std::optional<PlacementTotals> placement = {};  // absent: nothing is placed at random
  std::vector<SequenceFailure> failed;            // by number
  std::optional<Display> png;                     // of the 8-bit images of all sequences; absent: none
  DisplayCounts png_counts;                       // ... over all pings
  std::string fault;                    // as above
};

}  // namespace ensonify
