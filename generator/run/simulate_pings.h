// Pings of a scenario in memory, as a comparison measures them.
//
//   SimulateWish  simulate_pings
#pragma once

#include <optional>

#include "compare/pings.h"
#include "core/electronics.h"
#include "core/error.h"
#include "core/parallel.h"
#include "run/options.h"

namespace ensonify {

struct SimulateWish {
  const ScenarioOptions& input;
  Amount amount;
  // Reads the counts of the simulation as those of a recording of as many bits are read; absent:
  // by the scenario's own recorder.
  std::optional<Recorder> reader;
  bool (*stop)() = nullptr;
};

// The amplitudes that read_pings would find in the data set of the scenario: of the recorder's
// counts, if there is one, else of the stored levels. The scenario's `output` is ignored. Errors:
// those of open_source and open_sequence; (usage) sequences whose grids differ; (interrupted).
Result<PolarPings> simulate_pings(const SimulateWish& wish, const Workers& workers);

}  // namespace ensonify
