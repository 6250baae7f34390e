// The parts of the report about whole data sets and their growth, as text and as JSON.
//
//   rounded_text  times_json   also for stages
//   data_sets_json  data_sets_text  growth_json  growth_text
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/bench.h"

namespace ensonify {

// Three digits, or all before the point.
std::string rounded_text(double value);

nlohmann::ordered_json times_json(const std::vector<Timing>& timings);

nlohmann::ordered_json data_sets_json(const std::vector<DataSetReport>& data_sets);
nlohmann::ordered_json growth_json(const std::vector<GrowthReport>& growth);

// One table of data sets by files and one of their stages; empty where there are none.
std::string data_sets_text(const std::vector<DataSetReport>& data_sets);

// One table with the exponents below each size; empty where there is none.
std::string growth_text(const std::vector<GrowthReport>& growth);

}  // namespace ensonify
