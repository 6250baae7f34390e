// Totals over all pings of a data set, and the choice of shown pings. Private to report/.
//
//   spread           an even selection of a few among many
//   Survey  survey   totals, counts, ranges, paths; poses, boxes and masks of shown pings
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "dataset/read_dataset.h"

namespace ensonify {

// Selects `most` of `count` numbers, or all if there are fewer: the first, the last, and others
// evenly between them.
std::vector<std::uint64_t> spread(std::uint64_t count, std::uint64_t most);

struct SeenInstance {
  std::uint16_t instance = 0;
  std::uint64_t pixels = 0;
  std::optional<double> occlusion;
};

struct ShownPing {
  std::size_t sequence = 0;  // place in Survey::sequences
  std::uint32_t ping = 0;
  double time_s = 0;
  Pose sonar_in_world;
  std::vector<SeenInstance> seen;
  std::vector<StoredBox> boxes;
};

struct ShownSequence {
  StoredSequence stored;
  SequenceFacts facts;
  std::vector<Vec3> path;  // of the sonar, thinned
};

struct ClassCount {
  std::uint64_t instances = 0;  // in the worlds of all sequences, seen or not
  std::uint64_t images = 0;     // images that show at least one of them
  std::uint64_t pixels = 0, hidden = 0;
  std::vector<std::uint64_t> ranges;  // of mask centers, by the steps of Survey::range_edges_m
};

struct SplitCount {
  std::string name;
  std::uint64_t sequences = 0, pings = 0;
};

struct Survey {
  std::uint64_t pings = 0;
  std::vector<SplitCount> splits;   // those that have a sequence
  std::string view;                 // whose masks are counted: polar, cartesian, or none
  std::vector<ClassCount> classes;  // by class id - 1
  std::vector<double> range_edges_m;
  std::vector<ShownSequence> sequences;  // those of shown pings or statistics
  std::vector<ShownPing> shown;          // in the order of the data set
};

// Reads every ping's line of the tables, a few at a time, and chooses at most `most` pings to show.
// stop() is asked between pings; null: never stops. Error (interrupted): it said so.
Result<Survey> survey(const StoredDataset& dataset, std::uint64_t most, const Workers& workers,
                      bool (*stop)() = nullptr);

}  // namespace ensonify
