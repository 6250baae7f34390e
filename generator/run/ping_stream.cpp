#include "run/ping_stream.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace ensonify {
struct PingStream::State {
  struct MadePing {
    bool done = false;
    PingResult result;
    std::exception_ptr thrown;
  };

  struct Sequence {
    std::uint32_t number = 0;
    std::uint32_t skipped = 0;
    bool settled = false;                      // opened, or failed
    std::shared_ptr<const LiveSequence> live;  // until its last ping is made
    StreamedPing parts;                        // of its pings, without a result
    std::optional<Error> error;
    std::exception_ptr thrown;
    std::uint32_t taken = 0, last = 0;  // the next ping to be taken, and the end
    std::deque<MadePing> made;          // pings from `taken` on, made or in progress

    std::uint32_t next() const { return taken + static_cast<std::uint32_t>(made.size()); }
    bool has_failed() const { return error || thrown; }
    bool has_world() const { return !settled || live; }
  };

  struct OpenLane {
    StreamLane wish;
    std::deque<std::shared_ptr<Sequence>> open;  // pings are taken from the first
    bool all_opened = false;

    bool has_ended() const { return all_opened && open.empty(); }
    int worlds() const {
      return static_cast<int>(std::count_if(
          open.begin(), open.end(), [](const auto& sequence) { return sequence->has_world(); }));
    }
  };

  // The place in the order of taking.
  struct Turn {
    std::size_t lane = 0;
    std::uint32_t taken = 0;  // from this lane

    void end(std::size_t lane_count) { *this = {(lane + 1) % lane_count, 0}; }
    void take(std::uint32_t most, std::size_t lane_count) {
      if (++taken >= most) end(lane_count);
    }
  };

  // What a thread does next. Without `sequence`: open the next one of the lane; without `made`:
  // build its world.
  struct Task {
    OpenLane* lane = nullptr;
    std::shared_ptr<Sequence> sequence;
    std::uint32_t ping = 0;
    MadePing* made = nullptr;
  };

  StreamWish wish;
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<OpenLane> lanes;
  Turn turn;
  std::uint32_t usual_pings = 1;  // of the sequence that was opened last
  std::size_t ready = 0;
  int working = 0;  // threads
  bool stopped = false;
  std::exception_ptr thrown;
  std::vector<std::thread> threads;

  // Called with the mutex held.
  std::optional<Task> found_task();
  std::optional<Task> found_opening();
  std::optional<Task> started_task();
  bool may_open(const OpenLane& lane) const;
  std::uint32_t pings_left(const Sequence& sequence) const;
  Sequence* front();
  bool has_ended() const;
  bool is_ready();
  [[noreturn]] void end_with(const std::exception_ptr& exception);

  void do_task(const Task& task);
  void open_it(Sequence& sequence);
  void make_it(Sequence& sequence, std::uint32_t ping, MadePing& made);
  void make_pings();
};

// A sequence that is being opened is expected to be as long as the last one. One without pings
// counts as one, so that the number of open sequences is bounded even if all fail.
std::uint32_t PingStream::State::pings_left(const Sequence& sequence) const {
  return sequence.settled ? std::max(1u, sequence.last - sequence.taken) : usual_pings;
}

// Each lane may have one world, because pings may be taken from any, and all together may have as
// many more as there are threads. Sequences without pings or a world are bounded as well.
bool PingStream::State::may_open(const OpenLane& lane) const {
  const auto most = static_cast<std::size_t>(wish.ahead + wish.threads);
  if (lane.all_opened || lane.open.size() >= most) return false;
  if (lane.worlds() == 0) return true;
  int more = 0;
  for (const OpenLane& other : lanes) more += std::max(0, other.worlds() - 1);
  return more < wish.threads;
}

// The first that is due in the order of taking, which is followed for `ahead` pings.
std::optional<PingStream::State::Task> PingStream::State::found_task() {
  struct Head {
    std::size_t sequence = 0;
    std::uint32_t ping = 0;
  };
  std::vector<Head> heads(lanes.size());
  Turn at = turn;
  std::size_t ended = 0;  // lanes in a row
  for (int passed = 0; passed < wish.ahead && ended < lanes.size();) {
    OpenLane& lane = lanes[at.lane];
    Head& head = heads[at.lane];
    while (head.sequence < lane.open.size() && head.ping >= pings_left(*lane.open[head.sequence])) {
      head = {head.sequence + 1, 0};
    }
    const bool is_open = head.sequence < lane.open.size();
    if (!is_open && lane.all_opened) {
      ++ended;
      at.end(lanes.size());
      continue;
    }
    ended = 0;
    if (!is_open && may_open(lane)) return Task{&lane, nullptr};
    if (is_open) {
      const auto& sequence = lane.open[head.sequence];
      if (sequence->live && head.ping == sequence->made.size()) return Task{&lane, sequence};
    }
    ++head.ping;
    ++passed;
    at.take(wish.turn, lanes.size());
  }
  return found_opening();
}

// Beyond those pings, worlds alone are made in advance.
std::optional<PingStream::State::Task> PingStream::State::found_opening() {
  OpenLane* found = nullptr;
  std::uint64_t fewest = 0;
  for (OpenLane& lane : lanes) {
    if (!may_open(lane)) continue;
    std::uint64_t left = 0;
    for (const auto& sequence : lane.open) left += pings_left(*sequence);
    if (found != nullptr && left >= fewest) continue;
    found = &lane;
    fewest = left;
  }
  if (found == nullptr) return std::nullopt;
  return Task{found, nullptr};
}

std::optional<PingStream::State::Task> PingStream::State::started_task() {
  while (std::optional<Task> task = found_task()) {
    if (task->sequence) {
      task->ping = task->sequence->next();
      task->made = &task->sequence->made.emplace_back();
      return task;
    }
    OpenLane& lane = *task->lane;
    if (const auto number = lane.wish.next_sequence()) {
      task->sequence = std::make_shared<Sequence>();
      task->sequence->number = *number;
      task->sequence->skipped = std::exchange(lane.wish.skipped, 0);
      lane.open.push_back(task->sequence);
      return task;
    }
    lane.all_opened = true;
    changed.notify_all();
  }
  return std::nullopt;
}

void PingStream::State::open_it(Sequence& sequence) {
  std::optional<Result<std::shared_ptr<const LiveSequence>>> opened;
  std::exception_ptr trouble;
  try {
    opened = wish.open(sequence.number, Workers(wish.threads_within));
  } catch (...) {
    trouble = std::current_exception();
  }
  const std::lock_guard lock(mutex);
  sequence.settled = true;
  sequence.thrown = trouble;
  if (trouble) return;
  if (!*opened) {
    sequence.error = opened->error();
    return;
  }
  const LiveSequence& live = ***opened;
  sequence.parts = {live.info, live.tables, live.pings, {}};
  const auto [first, last] = wish.pings.value_or(live.pings);
  sequence.last = std::min(last, live.pings.second);
  sequence.taken = std::min(first + sequence.skipped, sequence.last);
  usual_pings = std::max(1u, sequence.last - sequence.taken);
  if (sequence.taken < sequence.last) sequence.live = std::move(**opened);
}

void PingStream::State::make_it(Sequence& sequence, std::uint32_t ping, MadePing& made) {
  try {
    made.result = live_ping(*sequence.live, ping, Workers(wish.threads_within));
  } catch (...) {
    made.thrown = std::current_exception();
  }
  std::shared_ptr<const LiveSequence> unneeded;  // freed without the mutex
  const std::lock_guard lock(mutex);
  made.done = true;
  ++ready;
  const auto is_done = [](const MadePing& other) { return other.done; };
  if (sequence.next() == sequence.last &&
      std::all_of(sequence.made.begin(), sequence.made.end(), is_done)) {
    unneeded = std::move(sequence.live);
  }
}

void PingStream::State::do_task(const Task& task) {
  if (task.made == nullptr) return open_it(*task.sequence);
  make_it(*task.sequence, task.ping, *task.made);
}

void PingStream::State::make_pings() {
  std::unique_lock lock(mutex);
  while (!stopped) {
    const std::optional<Task> task = started_task();
    if (!task) {
      changed.wait(lock);
      continue;
    }
    ++working;
    lock.unlock();
    do_task(*task);
    lock.lock();
    --working;
    changed.notify_all();
  }
}

// The sequence from which the next ping is taken; null: not known yet, or the end.
PingStream::State::Sequence* PingStream::State::front() {
  while (!has_ended()) {
    OpenLane& lane = lanes[turn.lane];
    if (lane.has_ended()) {
      turn.end(lanes.size());
      continue;
    }
    if (lane.open.empty()) return nullptr;
    Sequence& sequence = *lane.open.front();
    if (!sequence.settled || sequence.has_failed() || sequence.taken < sequence.last) {
      return &sequence;
    }
    lane.open.pop_front();
    changed.notify_all();
  }
  return nullptr;
}

bool PingStream::State::has_ended() const {
  return std::all_of(lanes.begin(), lanes.end(),
                     [](const OpenLane& lane) { return lane.has_ended(); });
}

bool PingStream::State::is_ready() {
  if (thrown) return true;
  const Sequence* sequence = front();
  if (sequence == nullptr) return has_ended();
  return sequence->has_failed() || (!sequence->made.empty() && sequence->made.front().done);
}

void PingStream::State::end_with(const std::exception_ptr& exception) {
  thrown = exception;
  stopped = true;
  changed.notify_all();
  std::rethrow_exception(thrown);
}

PingStream::PingStream(StreamWish wish) : state_(std::make_unique<State>()) {
  state_->wish = std::move(wish);
  for (const StreamLane& lane : state_->wish.lanes) state_->lanes.push_back({lane, {}, false});
  for (int i = 0; i < state_->wish.threads; ++i) {
    state_->threads.emplace_back([state = state_.get()] { state->make_pings(); });
  }
}

PingStream::~PingStream() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopped = true;
  }
  state_->changed.notify_all();
  for (std::thread& thread : state_->threads) thread.join();
}

bool PingStream::wait(std::chrono::milliseconds most) {
  std::unique_lock lock(state_->mutex);
  return state_->changed.wait_for(lock, most, [&] { return state_->is_ready(); });
}

std::optional<Result<StreamedPing>> PingStream::next() {
  State& state = *state_;
  std::unique_lock lock(state.mutex);
  state.changed.wait(lock, [&] { return state.is_ready(); });
  if (state.thrown) std::rethrow_exception(state.thrown);
  State::Sequence* sequence = state.front();
  if (sequence == nullptr) return std::nullopt;
  if (sequence->thrown) state.end_with(sequence->thrown);
  if (sequence->error) {
    const Error error = std::move(*sequence->error);
    state.lanes[state.turn.lane].open.pop_front();
    state.changed.notify_all();
    return Result<StreamedPing>(error);
  }
  State::MadePing& made = sequence->made.front();
  if (made.thrown) state.end_with(made.thrown);
  StreamedPing ping = sequence->parts;
  ping.result = std::move(made.result);
  sequence->made.pop_front();
  ++sequence->taken;
  --state.ready;
  if (sequence->taken == sequence->last) state.lanes[state.turn.lane].open.pop_front();
  state.turn.take(state.wish.turn, state.lanes.size());
  state.changed.notify_all();
  return Result<StreamedPing>(std::move(ping));
}

std::size_t PingStream::ready() const {
  const std::lock_guard lock(state_->mutex);
  return state_->ready;
}

bool PingStream::is_resting() const {
  const std::lock_guard lock(state_->mutex);
  return state_->working == 0 && !state_->found_task();
}

}  // namespace ensonify
