// Pings of a scenario in memory, as a comparison measures them.
//
//   simulate_pings
#pragma once

#include "app/commands.h"
#include "compare/pings.h"
#include "core/error.h"
#include "core/parallel.h"

namespace ensonify {

// The amplitudes that read_pings would find in the data set of the scenario: of the recorder's
// counts, if there is one, else of the stored levels. The scenario's `output` is ignored. Errors:
// those of open_source and open_sequence; (usage) sequences whose grids differ; (interrupted).
Result<PolarPings> simulate_pings(const ScenarioOptions& input, const Amount& amount,
                                  const Workers& workers, bool (*stop)());

}  // namespace ensonify
