// The moments of a fit: how they follow from the statistics of a comparison, and a file with those
// of all simulations, so that an interrupted fit goes on.
//
//   moments_of  moment_names   of a recording or a simulation
//   Evaluations                the simulations on disk
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "compare/block_statistics.h"
#include "core/error.h"
#include "fit/search.h"

namespace ensonify {

// All values of the statistics of pings but side lobes, curves value by value, in one order for
// every data set. Curves with a free constant are taken less their mean. Needs 2 blocks or more.
MomentSample moments_of(const BlockStatistics& measured);

// In the same order: "range_width", "level_by_range 4 m".
std::vector<std::string> moment_names(const BlockStatistics& measured);

// evaluations.jsonl: the identity of the fit, then a line for each simulation. A line that was cut
// off is ignored.
class Evaluations {
 public:
  // Reads the file if there is one. Error (usage): it is of another fit; (io).
  static Result<Evaluations> open(std::filesystem::path file, std::string identity);

  // Null if the values were not simulated.
  const MomentSample* find(std::span<const double> values) const;
  Status add(std::span<const double> values, const MomentSample& sample);
  std::size_t size() const { return of_values_.size(); }

 private:
  std::filesystem::path file_;
  std::map<std::vector<double>, MomentSample> of_values_;
};

}  // namespace ensonify
