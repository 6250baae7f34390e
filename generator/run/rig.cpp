#include "run/rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "run/sequence_worlds.h"
#include "scenario/drawn_sections.h"
#include "scenario/rig.h"
#include "world/path.h"

namespace ensonify {

Result<Instruments> instruments_of(ScenarioOptions& input) {
  if (!input.text) {
    Result<std::string> text = read_scenario_text(input.scenario);
    if (!text) return text.error();
    input.text = std::move(*text);
  }
  return instruments_in(*input.text, input.overrides);
}

ScenarioOptions with_instrument(ScenarioOptions input, const std::string& name) {
  input.overrides.push_back({"instrument", name});
  return input;
}

RigInstrument rig_instrument(const Session& session) {
  const Scenario& scenario = session.scenario;
  const InstrumentSpec& instrument = scenario.rig[*chosen_index(scenario)];
  const InstrumentKind kind = instrument_kind(scenario);
  if (drawn_section(scenario, "rig") != nullptr) return {instrument.name, kind, {}, {}, {}};
  return {instrument.name, kind, session.mount, ping_rate_hz(scenario), instrument.time_offset_s};
}

Result<PingRange> pings_in_time(PingRange asked, const Session& session) {
  const TrajectorySpec& trajectory = session.scenario.trajectory;
  const auto common = ping_times(trajectory, session.path);
  if (!common) return common.error();
  const auto [first, last] = asked;
  if (first >= last || last > common->size()) {
    return Error{ErrorKind::usage,
                 fmt::format("--pings {}:{}: the run has pings 0 to {} at the rate of the "
                             "trajectory; expected A:B with 0 <= A < B <= {}",
                             first, last, common->size() - 1, common->size())};
  }
  const double period_s = 1 / trajectory.ping_rate_hz;
  const double start_s = common->front(), rounding_s = 1e-6 * period_s;
  const auto ping_at = [&](std::uint32_t ping) {
    const double time_s = start_s + ping * period_s - rounding_s;
    const auto& times = session.ping_times_s;
    return static_cast<std::uint32_t>(std::ranges::lower_bound(times, time_s) - times.begin());
  };
  // The last ping of a path lies at its end, where a faster instrument has no more.
  const PingRange range{ping_at(first), ping_at(last)};
  if (range.first < range.second) return range;
  return Error{
      ErrorKind::usage,
      fmt::format("--pings {}:{}: the instrument has no ping from {:g} s to before {:g} s; "
                  "expected a range in which every instrument has one",
                  first, last, start_s + first * period_s, start_s + last * period_s)};
}

Error of_instrument(const std::string& name, const Error& error,
                    const std::filesystem::path& scenario) {
  const std::string file = scenario.string() + ":";
  if (error.message.starts_with(file) || error.message.starts_with("--set ")) return error;
  return {error.kind, fmt::format("{}: {}", name, error.message)};
}

}  // namespace ensonify
