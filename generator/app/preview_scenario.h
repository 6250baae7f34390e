// What a preview takes of a scenario: a few of its pings, and less of what only costs.
//
//   spread_pings      which pings
//   reduced_scenario  the scenario that is rendered
//   reduction_text    what is less in it, for people
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenario/scenario.h"

namespace ensonify {

// `count` of `pings` pings, from the first to the last, evenly; all where there are fewer. One is
// the first.
std::vector<std::uint32_t> spread_pings(std::uint32_t pings, std::uint32_t count);

// Polar pictures and labels alone, whatever the scenario writes. Unless it is `full`: half of the
// rays in elevation, one column of them a sector, half as many by need, but as many as speckle
// needs, and none fixed on surfaces. Beams, range and samples stay, and so does all that sounds.
Scenario reduced_scenario(const Scenario& scenario, bool full);

// "rays 512 x 57 for 512 x 114, 10 a cell for 20; pictures and labels alone"
std::string reduction_text(const Scenario& scenario, const Scenario& reduced);

}  // namespace ensonify
