// A rig: several instruments on one body, each with a data set of its own. A scenario with a rig is
// read for one of them, whose sonar is then Scenario::sonar.
//
//   rig_fields  chosen_sonar_tree   reading and writing
//   instruments_in                  the names in a text
//   chosen_index  for_instrument    of a scenario
//   instrument_seed  device_seed  ping_rate_hz   what an instrument has for itself
//   in_rig  path_in_rig             a key path of the chosen sonar as the text has it
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/fields.h"
#include "scenario/scenario.h"

namespace ensonify {

// The keys `rig` and `instrument`. Sets the scenario's sonar to that of the instrument.
void rig_fields(Fields& f, Scenario& scenario);

// The tree of a scenario with a rig as that of its instrument alone: `sonar` in place of `rig`. For
// checks of several sections. Needs an instrument that the rig has.
Node chosen_sonar_tree(const Node& root, std::size_t index);

// The names of the instruments of a text that has a rig and does not say for which of them it is to
// be read; empty otherwise. Wrong names are left out; reading the scenario reports them.
std::vector<std::string> instruments_in(const std::string& text,
                                        const std::vector<Override>& overrides);

// The place in Scenario::rig of the instrument for which the scenario was read; none without a rig.
std::optional<std::size_t> chosen_index(const Scenario& scenario);
// The same scenario for another instrument of its rig.
Scenario for_instrument(Scenario scenario, std::size_t index);

// Keys what belongs to an instrument alone: its noise and errors, and speckle that is not fixed on
// surfaces. None without a rig, where the seed of the scenario keys these as well.
std::optional<std::uint64_t> instrument_seed(const Scenario& scenario);
// That, or the seed of the scenario.
std::uint64_t device_seed(const Scenario& scenario);

// The rate of its pings, or that of the trajectory.
double ping_rate_hz(const Scenario& scenario);

// "rig.1.sonar.range_max_m" of "sonar.range_max_m", if the scenario was read for the second
// instrument of a rig.
std::string in_rig(std::string_view path, std::size_t index);
// The same for the instrument that a text or its overrides choose; the path itself without one.
std::string path_in_rig(const Node& tree, const std::string& path,
                        const std::vector<Override>& overrides);

}  // namespace ensonify
