#include "run/ping_stream.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace ensonify {
struct PingStream::State {
  struct Sequence {
    std::uint32_t number = 0;
    std::uint32_t skipped = 0;
    bool settled = false;  // opened, or failed
    std::shared_ptr<const LiveSequence> live;
    std::optional<Error> error;
    std::uint32_t next = 0, taken = 0, last = 0;  // next to be made, next to be taken, end
    std::map<std::uint32_t, PingResult> made;
  };

  // The next task of a thread; without `ping`: open the sequence.
  struct Task {
    std::shared_ptr<Sequence> sequence;
    std::optional<std::uint32_t> ping;
  };

  StreamWish wish;
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<std::shared_ptr<Sequence>> open;  // pings are taken from the first
  std::uint64_t opened = 0;  // of wish.sequence
  bool all_opened = false;
  int ahead = 0;  // pings made or in progress, not taken
  bool stopped = false;
  std::exception_ptr thrown;
  std::vector<std::thread> threads;

  // Called with the mutex held.
  std::optional<Task> task();
  std::optional<Task> ping_task();
  std::optional<Task> opening_task();
  bool is_ready() const;

  void do_task(const Task& task);
  void open_it(Sequence& sequence);
  void make_pings();
};

std::optional<PingStream::State::Task> PingStream::State::ping_task() {
  for (std::size_t i = 0; i < open.size(); ++i) {
    Sequence& sequence = *open[i];
    if (!sequence.live || sequence.next == sequence.last) continue;
    // Pings of later sequences must not block the pings that a caller waits for.
    const auto own = static_cast<int>(sequence.next - sequence.taken);
    if (ahead >= wish.ahead && (i > 0 || own >= wish.ahead)) continue;
    ++ahead;
    return Task{open[i], sequence.next++};
  }
  return std::nullopt;
}

std::optional<PingStream::State::Task> PingStream::State::opening_task() {
  if (all_opened || static_cast<int>(open.size()) > wish.threads) return std::nullopt;
  const std::optional<std::uint32_t> number = wish.sequence(opened);
  if (!number) {
    all_opened = true;
    changed.notify_all();
    return std::nullopt;
  }
  auto sequence = std::make_shared<Sequence>();
  sequence->number = *number;
  sequence->skipped = opened == 0 ? wish.skipped : 0;
  ++opened;
  open.push_back(sequence);
  return Task{std::move(sequence), std::nullopt};
}

std::optional<PingStream::State::Task> PingStream::State::task() {
  std::optional<Task> found = ping_task();
  return found ? found : opening_task();
}

void PingStream::State::open_it(Sequence& sequence) {
  auto live = wish.open(sequence.number, Workers(wish.threads_within));
  const std::lock_guard lock(mutex);
  sequence.settled = true;
  if (!live) {
    sequence.error = live.error();
    return;
  }
  sequence.live = std::move(*live);
  const auto [first, last] = wish.pings.value_or(sequence.live->pings);
  sequence.last = std::min(last, sequence.live->pings.second);
  sequence.next = sequence.taken = std::min(first + sequence.skipped, sequence.last);
}

void PingStream::State::do_task(const Task& task) {
  Sequence& sequence = *task.sequence;
  if (!task.ping) return open_it(sequence);
  PingResult result = live_ping(*sequence.live, *task.ping, Workers(wish.threads_within));
  const std::lock_guard lock(mutex);
  sequence.made.emplace(*task.ping, std::move(result));
}

void PingStream::State::make_pings() {
  std::unique_lock lock(mutex);
  while (!stopped) {
    const std::optional<Task> found = task();
    if (!found) {
      changed.wait(lock);
      continue;
    }
    lock.unlock();
    std::exception_ptr trouble;
    try {
      do_task(*found);
    } catch (...) {
      trouble = std::current_exception();
    }
    lock.lock();
    if (trouble && !thrown) thrown = trouble;
    stopped = stopped || thrown;
    changed.notify_all();
  }
}

bool PingStream::State::is_ready() const {
  if (thrown) return true;
  if (open.empty()) return all_opened;
  const Sequence& front = *open.front();
  if (!front.settled) return false;
  return front.error || front.taken == front.last || front.made.count(front.taken) > 0;
}

PingStream::PingStream(StreamWish wish) : state_(std::make_unique<State>()) {
  state_->wish = std::move(wish);
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
  while (true) {
    state.changed.wait(lock, [&] { return state.is_ready(); });
    if (state.thrown) std::rethrow_exception(state.thrown);
    if (state.open.empty()) return std::nullopt;
    State::Sequence& front = *state.open.front();
    if (front.error || front.taken == front.last) {
      const std::optional<Error> error = std::move(front.error);
      state.open.pop_front();
      state.changed.notify_all();
      if (error) return Result<StreamedPing>(*error);
      continue;
    }
    StreamedPing ping{front.live->info, front.live->tables, front.live->pings,
                      std::move(front.made.at(front.taken))};
    front.made.erase(front.taken++);
    --state.ahead;
    state.changed.notify_all();
    return Result<StreamedPing>(std::move(ping));
  }
}

}  // namespace ensonify
