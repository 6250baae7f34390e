#include "app/draw_session.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace ensonify {
namespace {

using Counts = std::map<std::string, std::uint64_t>;  // objects to be placed, by class

Counts placed_counts(const Scenario& scenario) {
  Counts counts;
  for (const ObjectSpec& spec : scenario.objects) counts[spec.class_name] += spec.place.has_value();
  std::erase_if(counts, [](const auto& entry) { return entry.second == 0; });
  return counts;
}

std::optional<Placement> placement_of(const Session& session, const Counts& first) {
  const Counts kept = placed_counts(session.scenario);
  if (kept.empty() && first.empty()) return std::nullopt;
  Placement placement{session.scenario.redraw, {}, session.world.left_out};
  Counts names = first;
  names.insert(kept.begin(), kept.end());
  const auto count_in = [](const Counts& counts, const std::string& name) {
    const auto found = counts.find(name);
    return found == counts.end() ? 0 : found->second;
  };
  for (const auto& [name, count] : names) {
    placement.classes.push_back({name, count_in(first, name), count_in(kept, name)});
  }
  return placement;
}

Error without_room(const Error& error) {
  return {ErrorKind::usage,
          fmt::format("{}; the sequence was sampled {} times", error.message, kMostRedraws + 1)};
}

}  // namespace

Result<Session> drawn_session(const DrawSteps& steps, std::uint32_t sequence) {
  Counts first;
  for (std::uint32_t redraw = 0;; ++redraw) {
    Result<Scenario> scenario = steps.scenario({sequence, redraw});
    if (!scenario) return scenario.error();
    if (redraw == 0) first = placed_counts(*scenario);
    Result<Session> session = steps.session(std::move(*scenario), sequence);
    if (session) {
      session->placement = placement_of(*session, first);
      return session;
    }
    if (session.error().kind != ErrorKind::redraw) return session.error();
    if (redraw == kMostRedraws) return without_room(session.error());
  }
}

}  // namespace ensonify
