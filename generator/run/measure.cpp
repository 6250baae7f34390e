#include "run/measure.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <ctime>
#include <mutex>
#include <optional>
#include <utility>

#include "core/moments.h"
#include "dataset/footprint.h"
#include "dataset/layout.h"
#include "dataset/write_ping.h"
#include "formats/sha256.h"
#include "ping/sequence_info.h"
#include "run/cost.h"
#include "run/display_limits.h"
#include "run/make_sequences.h"

namespace ensonify {
namespace {

using Clock = std::chrono::steady_clock;

// How often the tables and manifest of a sequence are read or written, for each time that
// ping_bytes goes through its bytes.
constexpr double kSequencePasses = 2;

// Seconds since `start`, which becomes now.
double lap_s(Clock::time_point& start) {
  const Clock::time_point now = Clock::now();
  return std::chrono::duration<double>(now - std::exchange(start, now)).count();
}

double process_core_s() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// The means of Measured, by what they are divided by.
constexpr std::array kOfSequence = {&Measured::world_s, &Measured::prepare_s,
                                    &Measured::sequence_bytes};
constexpr std::array kOfPing = {
    &Measured::finish_s,       &Measured::list_s,        &Measured::files, &Measured::piece,
    &Measured::sequence_lines, &Measured::dataset_lines, &Measured::record};
constexpr std::array kOfSomePings = {&Measured::first_ping_s, &Measured::ping_s};

struct MeasureRoom {
  const MeasureJob& job;
  int threads = 1;  // of a sequence
  Turns turns;
  double seconds = 0;                    // for the pings of those sequences
  std::array<double, 2> limits_db = {};  // of 8-bit images
  Clock::time_point start = {};
  std::mutex mutex = {};
  // Of all lanes.
  Measured sums = {};  // in place of means
  double busy_s = 0;
  std::uint64_t first_pings = 0;

  bool is_late() const {
    return std::chrono::duration<double>(Clock::now() - start).count() > seconds;
  }

  void add(const Measured& more, double more_busy_s) {
    const std::lock_guard lock(mutex);
    busy_s += more_busy_s;
    sums.pings += more.pings;
    sums.sequences += more.sequences;
    first_pings += more.first_ping_s > 0;
    // Sequences that find the parts of the shared world made have no share in this time.
    sums.once_s = std::max(sums.once_s, more.once_s);
    for (const auto sum : kOfSequence) sums.*sum += more.*sum;
    for (const auto sum : kOfPing) sums.*sum += more.*sum;
    for (const auto sum : kOfSomePings) sums.*sum += more.*sum;
  }
};

// Writes a file without a name, which vanishes when it is closed. If the disk does not store all of
// it, the measured time is too short, without other consequences.
void write_unnamed(const std::filesystem::path& folder, std::string_view bytes) {
  int descriptor = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
  if (descriptor < 0) descriptor = ::memfd_create("ensonify", MFD_CLOEXEC);
  if (descriptor < 0) return;
  [[maybe_unused]] const auto written = ::write(descriptor, bytes.data(), bytes.size());
  ::close(descriptor);
}

void store_unnamed(const MeasureJob& job, const EncodedPing& encoded) {
  if (job.disk.empty()) return;
  for (const EncodedFile& file : encoded.files) write_unnamed(job.disk, file.bytes);
  write_unnamed(job.disk, encoded.record);
}

// Arrays are hashed and written once more.
void join_unnamed(const MeasureJob& job, const EncodedPing& encoded) {
  if (job.disk.empty()) return;
  for (const EncodedFile& file : encoded.files) {
    if (file.name_template != layout::kPiece) continue;
    [[maybe_unused]] const std::string hash = sha256_hex(file.bytes);
    write_unnamed(job.disk, file.bytes);
  }
}

// What the time series of a ping takes that is added to the moments of an ensemble.
double moments_s(const SequenceInfo& info, const std::vector<std::complex<float>>& series) {
  if (!info.output.statistics) return 0;
  Moments moments(info.sonar.beam_count, info.record.samples);
  Clock::time_point start = Clock::now();
  add_block({&series, 1}, 0, 0, moments.beams, moments);
  return lap_s(start);
}

Result<EncodedPing> encoded_in_turn(MeasureRoom& room, const Pipeline& pipeline, std::uint32_t ping,
                                    PingStart start, const Workers& workers, double& seconds) {
  const Turn turn(room.turns);
  Clock::time_point began = Clock::now();
  const PingResult result = pipeline.run(ping, workers, std::move(start));
  Result<EncodedPing> encoded = encode_ping(pipeline.info(), result, workers);
  seconds = lap_s(began);
  seconds += moments_s(pipeline.info(), result.series);
  return encoded;
}

Status measure_ping(MeasureRoom& room, const Pipeline& pipeline, std::uint32_t ping,
                    PingStart start, const Workers& workers) {
  const SequenceInfo& info = pipeline.info();
  Measured one;
  double& ping_s = start.echoes ? one.first_ping_s : one.ping_s;
  const Result<EncodedPing> encoded =
      encoded_in_turn(room, pipeline, ping, std::move(start), workers, ping_s);
  if (!encoded) return encoded.error();
  Clock::time_point began = Clock::now();
  store_unnamed(room.job, *encoded);
  ping_s += lap_s(began);
  join_unnamed(room.job, *encoded);
  const double join_s = lap_s(began);
  const Result<PingBytes> bytes = ping_bytes(info, *encoded);
  if (!bytes) return bytes.error();
  one.list_s = lap_s(began);
  one.finish_s = join_s + kSequencePasses * one.list_s;
  one.pings = 1;
  one.files = static_cast<double>(bytes->files);
  one.piece = static_cast<double>(bytes->piece);
  one.sequence_lines = static_cast<double>(bytes->sequence_lines);
  one.dataset_lines = static_cast<double>(bytes->dataset_lines);
  one.record = static_cast<double>(bytes->record);
  if (ping == info.first_ping) {
    one.sequence_bytes = static_cast<double>(sequence_bytes(info, *encoded));
  }
  room.add(one, ping_s + join_s + one.list_s);
  return {};
}

Status measure_pings_of(MeasureRoom& room, ReadyPipeline& ready) {
  const SequenceInfo& info = ready.pipeline.info();
  const auto pings = spread_order(info.first_ping, info.last_ping, room.job.most_pings);
  const auto threads = static_cast<std::size_t>(room.threads);
  const std::size_t side_by_side = std::min(threads, pings.size());
  const int within = std::max(1, room.threads / static_cast<int>(side_by_side));
  return in_lanes(
      pings_under_way(room.threads, pings.size()), pings.size(), [&](std::size_t, std::size_t i) {
        if (i >= side_by_side && room.is_late()) return Status();
        PingStart start;
        if (pings[i] == 0) start = std::exchange(ready.ping_zero, {});
        return measure_ping(room, ready.pipeline, pings[i], std::move(start), Workers(within));
      });
}

// Prepares pings as make_sequences does, then again with the known parts if other sequences follow
// in the same world.
Result<ReadyPipeline> prepare_pings(MeasureRoom& room, const ReadyWorld& world,
                                    const SequenceInfo& info, SharedParts& shared) {
  const Turn turn(room.turns);
  const auto make = [&] {
    return make_pipeline(*world.session, *world.tracer, info, room.job.numerics,
                         Workers(room.threads), shared, info.first_ping == 0);
  };
  Measured one;
  Clock::time_point start = Clock::now();
  if (!room.job.vary && room.job.count() > 1) {
    if (const Result<ReadyPipeline> ready = make(); !ready) return ready.error();
    one.once_s = lap_s(start);
  }
  Result<ReadyPipeline> ready = make();
  one.prepare_s = lap_s(start);
  room.add(one, one.once_s + one.prepare_s);
  return ready;
}

Result<ReadyWorld> timed_world(MeasureRoom& room, std::uint32_t sequence) {
  const Turn turn(room.turns);
  Measured one;
  Clock::time_point start = Clock::now();
  Result<ReadyWorld> world = room.job.world(sequence);
  one.world_s = lap_s(start);
  room.add(one, one.world_s);
  return world;
}

Status measure_sequence(MeasureRoom& room, std::uint32_t sequence, SharedParts& first) {
  const bool is_first_world = !room.job.vary || sequence == room.job.first;
  SharedParts shared;
  if (is_first_world) {
    const std::lock_guard lock(room.mutex);
    shared = first;
  }
  const Result<ReadyWorld> world = timed_world(room, sequence);
  // A sequence that cannot be made has no pings and does not end the measurement.
  if (!world && world.error().kind == ErrorKind::usage) return {};
  if (!world) return world.error();
  const Result<PingRange> pings = range_of(room.job.pings, *world->session);
  if (!pings) return pings.error();
  SequenceInfo info = sequence_info(*world->session, sequence, pings->first, pings->second);
  info.png.limits_db = room.limits_db;
  Result<ReadyPipeline> ready = prepare_pings(room, *world, info, shared);
  if (!ready) return ready.error();
  if (is_first_world) {
    const std::lock_guard lock(room.mutex);
    first = shared;
  }
  Status measured = measure_pings_of(room, *ready);
  Measured one;
  one.sequences = 1;
  room.add(one, 0);
  return measured;
}

// The world of the first sequence exists already, so it does not show the time of building one.
std::vector<std::uint32_t> measured_sequences(const MeasureJob& job, int lanes) {
  const auto [first, last] = job.sequences;
  const bool leaves_first =
      job.vary && job.count() > 1 && job.most_sequences > 1 && first == job.first;
  const std::uint32_t most = job.vary
                                 ? job.most_sequences
                                 : std::min(job.most_sequences, static_cast<std::uint32_t>(lanes));
  return spread_order(first + leaves_first, last, most);
}

Measured means_of(const MeasureRoom& room, double core_s) {
  Measured m = room.sums;
  const auto divide = [&](const auto& sums, std::uint64_t count) {
    for (const auto sum : sums) m.*sum /= std::max(1.0, static_cast<double>(count));
  };
  divide(kOfSequence, m.sequences);
  divide(kOfPing, m.pings);
  divide(std::array{&Measured::first_ping_s}, room.first_pings);
  divide(std::array{&Measured::ping_s}, m.pings - room.first_pings);
  if (room.first_pings == 0) m.first_ping_s = m.ping_s;
  // Only ping 0 was measured, a part of which had been computed before.
  if (m.pings == room.first_pings) m.ping_s = m.first_ping_s + m.prepare_s + m.once_s;
  m.cores = room.busy_s > 0 ? core_s / room.busy_s : 1;
  return m;
}

int lanes_of(const MeasureJob& job) {
  return sequences_under_way(job.threads, job.pings_each, job.count(), job.vary);
}

}  // namespace

std::vector<std::uint32_t> spread_order(std::uint32_t first, std::uint32_t last,
                                        std::uint32_t most) {
  const std::uint32_t count = last - first;
  const std::uint32_t wanted = std::min(count, most);
  std::vector<std::uint32_t> order;
  std::vector<bool> seen(count);
  const auto add = [&](std::uint32_t i) {
    if (order.size() < wanted && !seen[i]) order.push_back(first + i);
    seen[i] = true;
  };
  if (count > 0) add(0);
  if (count > 1) add(count - 1);
  // The reversed bits of i run from coarse to fine positions.
  const int bits = std::bit_width(count);
  for (std::uint64_t i = 1; order.size() < wanted; ++i) {
    std::uint64_t reversed = 0;
    for (int bit = 0; bit < bits; ++bit) reversed |= (i >> bit & 1) << (bits - 1 - bit);
    add(static_cast<std::uint32_t>(reversed * count >> bits));
  }
  return order;
}

Result<Measured> measure_pings(const MeasureJob& job, SharedParts& first) {
  const int lanes = lanes_of(job);
  const std::vector<std::uint32_t> sequences = measured_sequences(job, lanes);
  // The limits determine how well images are compressed.
  const auto limits_db = display_limits_db(job.world, job.vary, job.numerics, Workers(job.threads));
  if (!limits_db) return limits_db.error();
  MeasureRoom room{job, std::max(1, job.threads / lanes), Turns(job.threads),
                   job.vary ? job.seconds / 3 : job.seconds, *limits_db};
  const Clock::time_point start = Clock::now();
  const double core_before_s = process_core_s();
  for (std::size_t i = 0; i < sequences.size(); i += static_cast<std::size_t>(lanes)) {
    room.start = Clock::now();
    if (i > 0 && room.start - start > std::chrono::duration<double>(job.seconds)) break;
    const std::size_t count = std::min<std::size_t>(lanes, sequences.size() - i);
    const Status done = in_lanes(lanes, count, [&](std::size_t, std::size_t k) {
      return measure_sequence(room, sequences[i + k], first);
    });
    if (!done) return done.error();
  }
  if (room.sums.sequences == 0) {
    if (Status done = measure_sequence(room, job.first, first); !done) return done.error();
  }
  return means_of(room, process_core_s() - core_before_s);
}

RunTime time_now() {
  return {std::chrono::duration<double>(Clock::now().time_since_epoch()).count(), process_core_s()};
}

RunTime time_of(const Measured& m, const MeasureJob& job) {
  const int lanes = lanes_of(job), threads = std::max(1, job.threads / lanes);
  const double sequences = job.count(), pings = job.pings_each;
  const double worlds = job.vary ? sequences - (job.sequences.first == job.first) : 0;
  const double pings_s = m.first_ping_s + (pings - 1) * m.ping_s;
  const double alone_s = m.once_s + sequences * pings * m.list_s;
  const double rest_s = worlds / sequences * m.world_s + m.prepare_s + pings * m.finish_s;
  // Pings are handed out one by one, so the last of them leave threads idle.
  const double rounds = std::ceil(pings / std::min<double>(threads, pings));
  return {alone_s + sequences * (rest_s + rounds * pings_s / pings) / std::min(lanes, job.threads),
          m.cores * (alone_s + sequences * (rest_s + pings_s))};
}

}  // namespace ensonify
