#include "app/measure.h"

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

#include "app/cost.h"
#include "app/display_limits.h"
#include "app/make_sequences.h"
#include "app/sequence_info.h"
#include "core/moments.h"
#include "dataset/footprint.h"
#include "dataset/layout.h"
#include "dataset/write_ping.h"
#include "formats/sha256.h"

namespace ensonify {
namespace {

using Clock = std::chrono::steady_clock;

// How often the tables and manifests of a sequence and of the data set are read or written, for
// each time that ping_bytes goes through its bytes.
constexpr double kSequencePasses = 2, kDatasetPasses = 1;

double elapsed_s(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double process_core_s() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct PingTime {
  bool is_started = false, is_cold = false;
  double seconds = 0, store_s = 0, join_s = 0, finish_s = 0;
};

// Sums of the measurements of all lanes.
struct MeasureSums {
  std::mutex mutex;
  Measured measured;  // sums in place of means
  double busy_s = 0;
  double moments_s = 0;
  double cold_ping_s = 0;  // of pings for which the process allocates new memory
  std::uint64_t first_pings = 0, warm_pings = 0, cold_pings = 0;

  void add_ping(const PingTime& time, const PingBytes& bytes) {
    const std::lock_guard lock(mutex);
    (time.is_started ? measured.first_ping_s
     : time.is_cold  ? cold_ping_s
                     : measured.ping_s) += time.seconds;
    ++(time.is_started ? first_pings : time.is_cold ? cold_pings : warm_pings);
    ++measured.pings;
    measured.store_s += time.store_s;
    measured.join_s += time.join_s;
    measured.finish_s += time.finish_s;
    measured.files += static_cast<double>(bytes.files);
    measured.piece += static_cast<double>(bytes.piece);
    measured.sequence_lines += static_cast<double>(bytes.sequence_lines);
    measured.dataset_lines += static_cast<double>(bytes.dataset_lines);
    measured.record += static_cast<double>(bytes.record);
    busy_s += time.seconds + time.store_s + time.join_s + time.finish_s;
  }
};

struct MeasureRoom {
  const MeasureJob& job;
  int threads = 1;  // of a sequence
  Turns turns;
  double seconds = 0;  // for the pings of those sequences
  Clock::time_point start = Clock::now();
  MeasureSums sums = {};
  std::atomic<int> begun = 0;            // pings
  std::array<double, 2> limits_db = {};  // of 8-bit images

  bool is_late() const { return elapsed_s(start) > seconds; }
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

// The time series of the first pings of an ensemble, whose moments are kept.
struct Block {
  std::mutex mutex;
  std::vector<std::vector<std::complex<float>>> series;
  std::uint64_t pings = 0;

  void add(std::vector<std::complex<float>> one) {
    const std::lock_guard lock(mutex);
    ++pings;
    if (series.size() < kMomentBlock) series.push_back(std::move(one));
  }
};

// Bytes of the moments, per ping.
double moments_s(const SequenceInfo& info, const Block& block) {
  if (block.series.empty()) return 0;
  Moments moments(info.sonar.beam_count, info.record.samples);
  const Clock::time_point start = Clock::now();
  add_block(block.series, 0, 0, moments.beams, moments);
  return elapsed_s(start) / static_cast<double>(block.series.size());
}

Result<EncodedPing> encoded_in_turn(MeasureRoom& room, const Pipeline& pipeline, std::uint32_t ping,
                                    PingStart start, const Workers& workers, Block& block,
                                    PingTime& time) {
  const Turn turn(room.turns);
  const Clock::time_point began = Clock::now();
  PingResult result = pipeline.run(ping, workers, std::move(start));
  Result<EncodedPing> encoded = encode_ping(pipeline.info(), result, workers);
  time.seconds = elapsed_s(began);
  if (pipeline.info().output.statistics) block.add(std::move(result.series));
  return encoded;
}

Status measure_ping(MeasureRoom& room, const Pipeline& pipeline, std::uint32_t ping,
                    PingStart start, const Workers& workers, Block& block) {
  const SequenceInfo& info = pipeline.info();
  PingTime time{start.echoes.has_value(), room.begun++ < room.job.threads};
  const Result<EncodedPing> encoded =
      encoded_in_turn(room, pipeline, ping, std::move(start), workers, block, time);
  if (!encoded) return encoded.error();
  Clock::time_point began = Clock::now();
  store_unnamed(room.job, *encoded);
  time.store_s = elapsed_s(std::exchange(began, Clock::now()));
  join_unnamed(room.job, *encoded);
  time.join_s = elapsed_s(std::exchange(began, Clock::now()));
  const Result<PingBytes> bytes = ping_bytes(info, *encoded);
  if (!bytes) return bytes.error();
  time.finish_s = elapsed_s(began);
  room.sums.add_ping(time, *bytes);
  const std::lock_guard lock(room.sums.mutex);
  if (ping == info.first_ping) {
    room.sums.measured.sequence_bytes += static_cast<double>(sequence_bytes(info, *encoded));
  }
  return {};
}

Status measure_pings_of(MeasureRoom& room, ReadyPipeline& ready) {
  const SequenceInfo& info = ready.pipeline.info();
  const auto pings = spread_order(info.first_ping, info.last_ping, room.job.most_pings);
  const auto threads = static_cast<std::size_t>(room.threads);
  const std::size_t side_by_side = std::min(threads, pings.size());
  const int within = std::max(1, room.threads / static_cast<int>(side_by_side));
  Block block;
  Status made = in_lanes(pings_under_way(room.threads, pings.size()), pings.size(),
                         [&](std::size_t, std::size_t i) {
                           if (i >= side_by_side && room.is_late()) return Status();
                           PingStart start;
                           if (pings[i] == 0) start = std::exchange(ready.ping_zero, {});
                           return measure_ping(room, ready.pipeline, pings[i], std::move(start),
                                               Workers(within), block);
                         });
  if (!made) return made;
  const double each_s = moments_s(info, block);
  const std::lock_guard lock(room.sums.mutex);
  room.sums.moments_s += each_s * static_cast<double>(block.pings);
  return {};
}

// Prepares pings as make_sequences does, then again with the known parts if other sequences follow
// in the same world.
Result<ReadyPipeline> prepare_pings(MeasureRoom& room, const ReadyWorld& world,
                                    const SequenceInfo& info, SharedParts& shared) {
  const Turn turn(room.turns);
  double seconds = 0, once_s = 0;
  const auto make = [&] {
    const Clock::time_point start = Clock::now();
    auto ready = make_pipeline(*world.session, *world.tracer, info, room.job.numerics,
                               Workers(room.threads), shared, info.first_ping == 0);
    seconds = elapsed_s(start);
    return ready;
  };
  if (!room.job.vary && room.job.count() > 1) {
    const Result<ReadyPipeline> ready = make();
    if (!ready) return ready.error();
    once_s = seconds;
  }
  Result<ReadyPipeline> ready = make();
  if (room.job.count() == 1) once_s = std::exchange(seconds, 0);
  const std::lock_guard lock(room.sums.mutex);
  room.sums.measured.once_s += once_s;
  room.sums.measured.prepare_s += seconds;
  room.sums.busy_s += once_s + seconds;
  return ready;
}

Result<ReadyWorld> timed_world(MeasureRoom& room, std::uint32_t sequence) {
  const Turn turn(room.turns);
  const Clock::time_point start = Clock::now();
  Result<ReadyWorld> world = room.job.world(sequence);
  const double seconds = elapsed_s(start);
  const std::lock_guard lock(room.sums.mutex);
  room.sums.measured.world_s += seconds;
  room.sums.busy_s += seconds;
  return world;
}

Status measure_sequence(MeasureRoom& room, std::uint32_t sequence, SharedParts& first) {
  const bool is_first_world = !room.job.vary || sequence == room.job.first;
  SharedParts shared;
  if (is_first_world) {
    const std::lock_guard lock(room.sums.mutex);
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
    const std::lock_guard lock(room.sums.mutex);
    first = shared;
  }
  Status measured = measure_pings_of(room, *ready);
  const std::lock_guard lock(room.sums.mutex);
  ++room.sums.measured.sequences;
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

double mean(double sum, std::uint64_t count) {
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

Measured means_of(const MeasureSums& sums, double core_s) {
  Measured m = sums.measured;
  for (double* of_sequence : {&m.once_s, &m.world_s, &m.prepare_s, &m.sequence_bytes}) {
    *of_sequence = mean(*of_sequence, m.sequences);
  }
  for (double* of_ping : {&m.store_s, &m.join_s, &m.finish_s, &m.files, &m.piece, &m.sequence_lines,
                          &m.dataset_lines, &m.record}) {
    *of_ping = mean(*of_ping, m.pings);
  }
  m.first_ping_s = mean(m.first_ping_s, sums.first_pings);
  m.ping_s = sums.warm_pings > 0 ? mean(m.ping_s, sums.warm_pings)
                                 : mean(sums.cold_ping_s, sums.cold_pings);
  if (sums.first_pings == 0) m.first_ping_s = m.ping_s;
  // Only ping 0 was measured, a part of which had been computed before.
  if (sums.warm_pings + sums.cold_pings == 0) m.ping_s = m.first_ping_s + m.prepare_s + m.once_s;
  for (double* of_ping : {&m.first_ping_s, &m.ping_s}) *of_ping += mean(sums.moments_s, m.pings);
  m.cores = sums.busy_s > 0 ? core_s / sums.busy_s : 1;
  return m;
}

int lanes_of(const MeasureJob& job) {
  return sequences_under_way(job.threads, job.pings_each, job.count(), job.vary);
}

// Pings that are handed out one by one.
double makespan_s(double first_s, double ping_s, double pings, int threads) {
  if (threads == 1 || pings > 50.0 * threads) return (first_s + (pings - 1) * ping_s) / threads;
  std::vector<double> busy_s(static_cast<std::size_t>(threads));
  busy_s[0] = first_s;
  for (int i = 1; i < pings; ++i) *std::min_element(busy_s.begin(), busy_s.end()) += ping_s;
  return *std::max_element(busy_s.begin(), busy_s.end());
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
  MeasureRoom room{job, std::max(1, job.threads / lanes), Turns(job.threads),
                   job.vary ? job.seconds / 3 : job.seconds};
  // The limits determine how well images are compressed.
  const auto limits_db = display_limits_db(job.world, job.vary, job.numerics, Workers(job.threads));
  if (!limits_db) return limits_db.error();
  room.limits_db = *limits_db;
  const Clock::time_point start = Clock::now();
  const double core_before_s = process_core_s();
  for (std::size_t i = 0; i < sequences.size(); i += static_cast<std::size_t>(lanes)) {
    if (i > 0 && elapsed_s(start) > job.seconds) break;
    room.start = Clock::now();
    const std::size_t count = std::min<std::size_t>(lanes, sequences.size() - i);
    const Status done = in_lanes(lanes, count, [&](std::size_t, std::size_t k) {
      return measure_sequence(room, sequences[i + k], first);
    });
    if (!done) return done.error();
  }
  if (room.sums.measured.sequences == 0) {
    if (Status done = measure_sequence(room, job.first, first); !done) return done.error();
  }
  return means_of(room.sums, process_core_s() - core_before_s);
}

RunTime time_now() {
  return {std::chrono::duration<double>(Clock::now().time_since_epoch()).count(), process_core_s()};
}

RunTime time_of(const Measured& m, const MeasureJob& job) {
  const int lanes = lanes_of(job), threads = std::max(1, job.threads / lanes);
  const double sequences = job.count(), pings = job.pings_each, all_pings = sequences * pings;
  const double world_s = job.vary ? m.world_s : 0;
  const double known_s = job.vary && job.sequences.first == job.first ? world_s : 0;
  const double finish_s = (m.join_s + kSequencePasses * m.finish_s) * pings;
  const double end_s = kDatasetPasses * m.finish_s * all_pings;
  const double pings_s = m.first_ping_s + (pings - 1) * m.ping_s;

  // There are a few more pings than threads: one is written while others are computed.
  const int side_by_side = static_cast<int>(std::min<double>(threads, std::ceil(pings)));
  const double at_once = std::min<double>(threads + 1 + threads / 4, pings);
  const auto with_store_s = [&](double ping_s) {
    return std::max(ping_s, (ping_s + m.store_s) * side_by_side / at_once);
  };
  const double lane_s =
      world_s + m.prepare_s + finish_s +
      makespan_s(with_store_s(m.first_ping_s), with_store_s(m.ping_s), pings, side_by_side);
  const double turns_s = sequences * (world_s + m.prepare_s + pings_s) / job.threads;
  return {m.once_s + std::max(lane_s * sequences / lanes, turns_s) - known_s + end_s,
          m.cores * (m.once_s +
                     sequences * (world_s + m.prepare_s + pings_s + pings * m.store_s + finish_s) -
                     known_s + end_s)};
}

}  // namespace ensonify
