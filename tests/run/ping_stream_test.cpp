// Pings that come without files: in order, from a bounded window, over failures, to a clean end.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "catch.h"
#include "results.h"
#include "run/ping_stream.h"

using namespace ensonify;

namespace {

constexpr const char* kMovingBall = R"(ensonify: 1
seed: 4
sonar:
  preset: blueview_p900_90
  range_max_m: 3
  beams: {count: 8, fov_deg: 8}
  rays: {elevation: 4, min_per_cell: 0}
materials: {m: {reflectivity: 1e-2}}
objects:
  - {name: ball, material: m, shape: {sphere: {radius_m: {uniform: [0.2, 0.5]}}}, pose: {position_m: [2, 0, 0]}}
trajectory: {pings: 5}
output: {cartesian: false, png: false}
noise: {spectrum_level_db: 40}
)";

struct Balls {
  std::shared_ptr<StreamSource> source;
  std::atomic<int> opened = 0;

  explicit Balls(const std::string& pings = "5") {
    source = value_of(
        open_source({"ball.yaml", {{"trajectory.pings", pings}}, kMovingBall}, BackendChoice::cpu));
  }

  static StreamLane lane(std::uint32_t first, std::uint32_t end, std::uint32_t step) {
    return {[next = first, end, step]() mutable -> std::optional<std::uint32_t> {
      if (next >= end) return std::nullopt;
      return std::exchange(next, next + step);
    }};
  }

  // Of the sequences 0 ... count - 1, of which 2 cannot be made.
  StreamWish wish(std::uint32_t count, int threads) {
    StreamWish wanted;
    wanted.lanes = {lane(0, count, 1)};
    wanted.open = [this](std::uint32_t sequence,
                         const Workers& workers) -> Result<std::shared_ptr<const LiveSequence>> {
      ++opened;
      if (sequence == 2) return Error{ErrorKind::usage, "two"};
      const OutputSelection& output = source->worlds.first().scenario.output.selection;
      return open_sequence(*source, sequence, output, workers);
    };
    wanted.threads = threads;
    wanted.ahead = 3;
    return wanted;
  }
};

using Taken = std::vector<std::pair<std::uint32_t, Series>>;

// (100 sequence + ping, series); what fails has no series.
Taken all_of(PingStream& stream) {
  Taken taken;
  while (const auto next = stream.next()) {
    if (!*next) {
      taken.push_back({999, {}});
    } else {
      const StreamedPing& ping = **next;
      taken.push_back({100 * ping.info->sequence + ping.result.ping, ping.result.series});
    }
  }
  return taken;
}

std::vector<std::uint32_t> numbers_of(const Taken& taken) {
  std::vector<std::uint32_t> numbers;
  for (const auto& [number, series] : taken) numbers.push_back(number);
  return numbers;
}

// The number of ready pings when no more are made.
std::size_t ready_at_rest(const PingStream& stream) {
  while (!stream.is_resting()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return stream.ready();
}

}  // namespace

TEST_CASE("A stream gives the pings of all sequences in order for any number of threads",
          "[ping_stream]") {
  Balls balls;
  Taken expected;
  for (const int threads : {1, 2, 5}) {
    PingStream stream(balls.wish(4, threads));
    const Taken taken = all_of(stream);
    CHECK(numbers_of(taken) == std::vector<std::uint32_t>{0, 1, 2, 3, 4, 100, 101, 102, 103, 104,
                                                          999, 300, 301, 302, 303, 304});
    if (expected.empty()) expected = taken;
    CHECK(taken == expected);
    CHECK_FALSE(stream.next());
  }
  CHECK(expected[0].second != expected[1].second);
}

TEST_CASE("Lanes give their pings in turn, whatever the threads and the pings ahead",
          "[ping_stream]") {
  Balls balls;
  Taken expected;
  for (const auto& [threads, ahead] : {std::pair{1, 1}, {2, 3}, {4, 9}, {3, 100}}) {
    StreamWish wish = balls.wish(0, threads);
    wish.lanes = {Balls::lane(0, 5, 2), Balls::lane(1, 5, 2), Balls::lane(9, 9, 1)};
    wish.turn = 3;
    wish.ahead = ahead;
    PingStream stream(std::move(wish));
    const Taken taken = all_of(stream);
    CHECK(numbers_of(taken) == std::vector<std::uint32_t>{0,   1,   2,   100, 101, 102, 3,
                                                          4,   999, 400, 103, 104, 300, 401,
                                                          402, 403, 301, 302, 303, 404, 304});
    if (expected.empty()) expected = taken;
    CHECK(taken == expected);
  }
}

TEST_CASE("A stream keeps as many pings ready as it was asked for, and no more", "[ping_stream]") {
  for (const char* pings : {"1", "2", "5"}) {
    Balls balls(pings);
    for (const auto& [threads, ahead] : {std::pair{1, 7}, {2, 1}, {3, 8}}) {
      INFO(pings << " pings, " << threads << " threads, " << ahead << " ahead");
      StreamWish wish = balls.wish(1000, threads);
      wish.lanes = {Balls::lane(100, 1000, 2), Balls::lane(101, 1000, 2)};
      wish.turn = 2;
      wish.ahead = ahead;
      balls.opened = 0;
      PingStream stream(std::move(wish));
      for (int taken = 0; taken < 4; ++taken) {
        CHECK(ready_at_rest(stream) == static_cast<std::size_t>(ahead));
        // A world for each of these pings, and as many more as lanes and threads.
        CHECK(balls.opened <= taken + ahead + 2 + threads);
        const auto next = stream.next();
        REQUIRE((next && *next));
      }
    }
  }
}

TEST_CASE("A stream skips the pings that were taken before", "[ping_stream]") {
  Balls balls;
  StreamWish wish = balls.wish(2, 2);
  wish.lanes.front().skipped = 3;
  PingStream stream(std::move(wish));
  CHECK(numbers_of(all_of(stream)) == std::vector<std::uint32_t>{3, 4, 100, 101, 102, 103, 104});
}

TEST_CASE("Sequences that all fail are opened no further than pings are made", "[ping_stream]") {
  Balls balls;
  StreamWish wish = balls.wish(1'000'000, 2);
  wish.open = [&](std::uint32_t, const Workers&) -> Result<std::shared_ptr<const LiveSequence>> {
    ++balls.opened;
    return Error{ErrorKind::usage, "all"};
  };
  PingStream stream(std::move(wish));
  for (int taken = 0; taken < 3; ++taken) {
    CHECK(ready_at_rest(stream) == 0);
    CHECK(balls.opened == taken + 3 + 2);
    const auto next = stream.next();
    REQUIRE(next);
    CHECK_FALSE(*next);
  }
}

TEST_CASE("What a thread of a stream throws is thrown to its reader in place of the ping",
          "[ping_stream]") {
  for (const int threads : {1, 3}) {
    Balls balls("1");
    StreamWish wish = balls.wish(1000, threads);
    wish.ahead = 20;
    wish.open = [open = wish.open](std::uint32_t sequence, const Workers& workers) {
      if (sequence >= 4) throw std::runtime_error(std::to_string(sequence));
      return open(sequence, workers);
    };
    PingStream stream(std::move(wish));
    CHECK(ready_at_rest(stream) == 3);
    for (const std::uint32_t sequence : {0u, 1u})
      CHECK((**stream.next()).info->sequence == sequence);
    CHECK_FALSE(*stream.next());
    CHECK((**stream.next()).info->sequence == 3);
    for (int again = 0; again < 2; ++again) CHECK_THROWS_WITH(stream.next(), "4");
  }
}

TEST_CASE("A live ping has the levels that files hold", "[ping_stream]") {
  Balls balls;
  PingStream stream(balls.wish(1, 1));
  const auto ping = stream.next();
  REQUIRE((ping && *ping));
  const std::vector<float>& levels = (*ping)->result.polar->level_db;
  // A half has ten bits behind the first: of a level between 64 and 128 dB those of 1/16 dB.
  int between = 0;
  for (const float level : levels) {
    if (level < 64 || level >= 128) continue;
    CHECK(level * 16 == std::floor(level * 16));
    ++between;
  }
  CHECK(between > 10);
}
