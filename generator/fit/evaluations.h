// The simulations of a fit on disk, so that an interrupted fit goes on.
//
//   Evaluations
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/error.h"
#include "fit/search.h"

namespace ensonify {

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
