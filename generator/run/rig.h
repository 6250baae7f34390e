// The instruments of a rig as data sets that are made together.
//
//   Instruments  instruments_of   what `generate` and `check` make of the options of a rig
//   rig_file
//   pings_in_time                 --pings of an instrument with a clock of its own
//   of_instrument                 an error with the name of its instrument
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/rig_file.h"
#include "ping/session.h"
#include "run/options.h"

namespace ensonify {

// Empty unless the scenario has a rig and does not choose one of its instruments.
using Instruments = std::vector<std::string>;
// Reads the text of the scenario into `input`, so that standard input is read once. Errors: those
// of read_scenario_text.
Result<Instruments> instruments_of(ScenarioOptions& input);

// The options for one instrument.
ScenarioOptions with_instrument(ScenarioOptions input, const std::string& name);

// The entry of the session's instrument. What is sampled is absent.
RigInstrument rig_instrument(const Session& session);

// The pings of the session's instrument from ping `first` to before ping `last` of the rate of the
// trajectory. Errors (usage): the run has fewer pings at that rate; the instrument has none then.
Result<PingRange> pings_in_time(PingRange asked, const Session& session);

// Unchanged if the error names its place in the scenario.
Error of_instrument(const std::string& name, const Error& error,
                    const std::filesystem::path& scenario);

}  // namespace ensonify
