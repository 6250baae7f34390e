// The parts of a session that belong to its sonar. Private to ping/.
//
//   all_errors
//   prepare_sonar   sonar, water, record, cell and mount
//   times_of        when it pings
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/error.h"
#include "ping/session.h"

namespace ensonify {

// Collects the errors of all results, one per line.
template <class... Results>
std::optional<Error> all_errors(const Results&... results) {
  std::optional<Error> all;
  const auto add = [&](const auto& result) {
    if (result) return;
    if (!all) {
      all = result.error();
    } else {
      all->message += "\n" + result.error().message;
    }
  };
  (add(results), ...);
  return all;
}

// Sets the parts of a session that follow from the sonar and the water alone; with `has_cell` also
// the resolution cell, which takes most of the time and is needed only with a world. Errors
// (usage): tables that cannot be read, a pulse without a spectrum, too many looks of a detector, an
// array that contradicts its beams.
Status prepare_sonar(const Scenario& scenario, bool has_cell, Session& session);

// The times of all pings. Errors (usage): those of ping_times; an instrument of a rig without a
// ping.
Result<std::vector<double>> times_of(const Scenario& scenario, const Path& path,
                                     std::uint32_t sequence);

}  // namespace ensonify
