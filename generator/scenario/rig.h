// A rig: several instruments on one body, each with a data set of its own. A scenario with a rig is
// read for one of them, whose sonar, camera or sensors are then those of the scenario.
//
//   rig_fields  chosen_sonar_tree   reading and writing
//   select_outputs                  the files that an instrument can have
//   instruments_in                  the names in a text
//   chosen_index  for_instrument  instrument_kind  need_sonar  has_camera   of a scenario
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

// The keys `rig` and `instrument`. Sets the scenario's sonar, camera and navigation to what the
// instrument has.
void rig_fields(Fields& f, Scenario& scenario);

// Of a scenario that was read for an instrument: a sonar has no files of a camera, a camera no
// others, and navigation none but its tables. What the text states moves to Scenario::rig_output.
void select_outputs(Scenario& scenario);

// The tree of a scenario with a rig as that of its instrument alone: `sonar` in place of `rig`. For
// checks of several sections. Needs an instrument that the rig has.
Node chosen_sonar_tree(const Node& root, std::size_t index);

// The names of the instruments of a text that has a rig and does not say for which of them it is to
// be read; empty otherwise. Wrong names are left out; reading the scenario reports them.
std::vector<std::string> instruments_in(const std::string& text,
                                        const std::vector<Override>& overrides);

// The place in Scenario::rig of the instrument for which the scenario was read; none without a rig.
std::optional<std::size_t> chosen_index(const Scenario& scenario);
// The same scenario for another instrument of its rig, with the outputs unchanged.
Scenario for_instrument(Scenario scenario, std::size_t index);

// A sonar without a rig.
InstrumentKind instrument_kind(const Scenario& scenario);
inline bool is_sonar(const Scenario& scenario) {
  return instrument_kind(scenario) == InstrumentKind::sonar;
}
// Error (usage): the scenario was read for another instrument.
Status need_sonar(const Scenario& scenario);
// Whether the scenario, or an instrument of its rig, has one.
bool has_camera(const Scenario& scenario);

// Keys what belongs to an instrument alone: its noise and errors, and speckle that is not fixed on
// surfaces. None without a rig, where the seed of the scenario keys these as well.
std::optional<std::uint64_t> instrument_seed(const Scenario& scenario);
// That, or the seed of the scenario.
std::uint64_t device_seed(const Scenario& scenario);

// The rate of its pings, of a camera its images, or that of the trajectory.
double ping_rate_hz(const Scenario& scenario);

// "rig.1.sonar.range_max_m" of "sonar.range_max_m", and so for a camera and navigation, if the
// scenario was read for the second instrument of a rig.
std::string in_rig(std::string_view path, std::size_t index);
// The same for the instrument that a text or its overrides choose; the path itself without one.
std::string path_in_rig(const Node& tree, const std::string& path,
                        const std::vector<Override>& overrides);

}  // namespace ensonify
