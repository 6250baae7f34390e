// Pings that come without files: in order, from a bounded window, over failures, to a clean end.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

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

  Balls() {
    auto made = value_of(open_source({"ball.yaml", {}, kMovingBall}, BackendChoice::cpu));
    source = made;
  }

  // Of the sequences 0 ... count - 1, of which 2 cannot be made.
  StreamWish wish(std::uint32_t count, int threads) {
    StreamWish wanted;
    wanted.sequence = [count](std::uint64_t i) -> std::optional<std::uint32_t> {
      if (i >= count) return std::nullopt;
      return static_cast<std::uint32_t>(i);
    };
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

using Taken = std::vector<std::pair<std::uint32_t, std::vector<std::complex<float>>>>;

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

}  // namespace

TEST_CASE("A stream gives the pings of all sequences in order for any number of threads",
          "[ping_stream]") {
  Balls balls;
  Taken expected;
  for (const int threads : {1, 2, 5}) {
    PingStream stream(balls.wish(4, threads));
    const Taken taken = all_of(stream);
    std::vector<std::uint32_t> numbers;
    for (const auto& [number, series] : taken) numbers.push_back(number);
    CHECK(numbers == std::vector<std::uint32_t>{0,   1,   2,   3,   4,   100, 101, 102,
                                                103, 104, 999, 300, 301, 302, 303, 304});
    if (expected.empty()) expected = taken;
    CHECK(taken == expected);
    CHECK_FALSE(stream.next());
  }
  CHECK(expected[0].second != expected[1].second);
}

TEST_CASE("A stream makes no more ahead than its window, and skips what was had before",
          "[ping_stream]") {
  Balls balls;
  StreamWish wish = balls.wish(1000, 2);
  wish.skipped = 3;
  PingStream stream(std::move(wish));
  const auto first = stream.next();
  REQUIRE((first && *first));
  CHECK((*first)->result.ping == 3);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  // As many sequences as threads, and one; the first may have gone.
  CHECK(balls.opened <= 4);
}

TEST_CASE("What is thrown by a thread of a stream is thrown to its reader", "[ping_stream]") {
  Balls balls;
  StreamWish wish = balls.wish(4, 2);
  wish.open = [](std::uint32_t,
                 const Workers&) -> Result<std::shared_ptr<const LiveSequence>> {
    throw std::runtime_error("no memory");
  };
  PingStream stream(std::move(wish));
  CHECK_THROWS_AS(stream.next(), std::runtime_error);
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
