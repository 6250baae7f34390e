#include "python/scenario.h"

#include <unistd.h>

#include <algorithm>

#include "python/values.h"
#include "scenario/draw.h"

namespace ensonify::python {
namespace {

// The returned function gives the next sequence at each call; calls must not overlap.
std::function<std::optional<std::uint32_t>()> numbers_of(const LaneRequest& request,
                                                         const std::string& split,
                                                         const Scenario& scenario) {
  const std::uint64_t count =
      request.listed.empty()
          ? (std::max(request.stop, request.start) - request.start + request.step - 1) /
                request.step
          : request.listed.size();
  const auto number = [request](std::uint64_t i) {
    const bool is_listed = !request.listed.empty();
    return is_listed ? request.listed[i]
                     : static_cast<std::uint32_t>(request.start + i * request.step);
  };
  return [next = std::uint64_t{0}, count, number, split, splits = scenario.splits,
          seed = scenario.seed]() mutable -> std::optional<std::uint32_t> {
    while (next < count) {
      const std::uint32_t found = number(next++);
      if (split.empty() || pick_split(splits, seed, found) == split) return found;
    }
    return std::nullopt;
  };
}

}  // namespace

Status claim_process() {
  static std::atomic<pid_t> owner = 0;
  const pid_t own = ::getpid();
  pid_t found = 0;
  if (owner.compare_exchange_strong(found, own) || found == own) return {};
  return Error{ErrorKind::device,
               "this process was forked from one that had already built a world, and the threads "
               "of that world were not copied; build the first world after the fork, or start "
               "workers with the method `spawn` of multiprocessing"};
}

Result<std::shared_ptr<CheckedScenario>> CheckedScenario::open(ScenarioOptions input,
                                                               BackendChoice backend) {
  const std::string label = input.scenario.string();
  const std::filesystem::path folder = input.scenario.parent_path();
  Result<Scenario> first =
      first_readable(is_sampled(*input.text, input.overrides), [&](std::uint32_t sequence) {
        return parse_scenario(*input.text, label, folder, input.overrides, sequence);
      });
  if (!first) return first.error();
  if (first->has_draws) {
    const Status draws = check_draws(*input.text, label, folder, input.overrides);
    if (!draws) return draws.error();
  }
  auto scenario = std::make_shared<CheckedScenario>();
  scenario->input_ = std::move(input);
  scenario->backend_ = backend;
  scenario->first_ = std::move(*first);
  return scenario;
}

Result<std::string> CheckedScenario::sample(std::uint32_t sequence) {
  const auto opened = source();
  if (!opened) return opened.error();
  Result<Session> session = (*opened)->worlds.session(sequence, ErrorPlaces::shown);
  if (!session) return session.error();
  session->scenario.drawn_sections = nullptr;
  return to_yaml(session->scenario,
                 [](const std::filesystem::path& file) { return file.string(); });
}

Result<std::shared_ptr<StreamSource>> CheckedScenario::source() {
  const std::lock_guard lock(mutex_);
  if (Status claimed = claim_process(); !claimed) return claimed.error();
  if (source_) return source_;
  auto opened = open_source(input_, backend_);
  if (opened) source_ = *opened;
  return opened;
}

std::vector<std::string> CheckedScenario::new_warnings() {
  const std::lock_guard lock(mutex_);
  return source_ ? std::exchange(source_->warnings, {}) : std::vector<std::string>();
}

Result<std::uint32_t> CheckedScenario::pings_of(std::uint32_t sequence) {
  const auto opened = source();
  if (!opened) return opened.error();
  const Result<SequenceInfo> info = (*opened)->worlds.info(sequence, std::nullopt);
  if (!info) return info.error();
  return info->last_ping - info->first_ping;
}

Result<std::shared_ptr<const LiveSequence>> CheckedScenario::sequence(std::uint32_t number,
                                                                      const OutputSelection& output,
                                                                      const Workers& workers) {
  const auto opened = source();
  if (!opened) return opened.error();
  const std::vector<std::string> flags = flags_of(output);
  {
    const std::lock_guard lock(mutex_);
    if (last_.live && last_.number == number && last_.flags == flags) return last_.live;
  }
  auto live = open_sequence(**opened, number, output, workers);
  if (live) {
    const std::lock_guard lock(mutex_);
    last_ = {number, flags, *live};
  }
  return live;
}

Result<std::shared_ptr<PingStream>> stream_of(const std::shared_ptr<CheckedScenario>& scenario,
                                              StreamRequest request) {
  const auto source = scenario->source();
  if (!source) return source.error();
  const OutputSelection output = selection_of(scenario->first().output.selection, request.flags);
  StreamWish wish;
  for (const LaneRequest& lane : request.lanes) {
    wish.lanes.push_back({numbers_of(lane, request.split, scenario->first()), lane.skipped});
  }
  wish.turn = request.turn;
  // A single sequence may be requested again for each ping.
  const bool keeps = request.lanes.size() == 1 && request.lanes.front().listed.size() == 1;
  wish.open = [scenario, source = *source, output, keeps](std::uint32_t number,
                                                          const Workers& workers) {
    return keeps ? scenario->sequence(number, output, workers)
                 : open_sequence(*source, number, output, workers);
  };
  wish.pings = request.pings;
  wish.threads = request.threads;
  wish.threads_within = request.threads_within;
  wish.ahead = request.ahead;
  return std::make_shared<PingStream>(std::move(wish));
}

}  // namespace ensonify::python
