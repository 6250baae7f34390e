#include "run/measure.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "core/moments.h"
#include "dataset/footprint.h"
#include "dataset/layout.h"
#include "dataset/write_ping.h"
#include "formats/sha256.h"
#include "ping/pipeline.h"
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

// What stands for all sequences.
struct Probe {
  LookedSequence of;
  SharedParts shared;
  RunTime time;  // for the limits
};

struct Probes {
  std::vector<Probe> made;
  double world_s = 0;  // for building the last world
  std::array<double, 2> limits_db = {};
};

Result<Probes> probe_run(const MeasureJob& job) {
  const auto given_db = given_limits_db(job.worlds.first().scenario.output);
  const Workers workers(job.threads);
  Probes probes;
  EchoLevels levels;
  const auto world_of = [&](std::uint32_t sequence) {
    const RunTime start = time_now();
    Result<ReadyWorld> world = job.worlds.world(sequence);
    probes.world_s = (time_now() - start).core_s;
    return world;
  };
  const auto use = [&](std::uint32_t sequence, const ReadyWorld& world) -> Status {
    Probe probe{{sequence, world, {}}, {}, {}};
    const RunTime start = time_now();
    // Without an echo for the noise, the sequence stands for no other.
    if (!given_db || world.session->scenario.noise_snr_db) {
      const Result<EchoLevels> more =
          probe_levels(world, sequence, job.numerics, workers, probe.shared, true);
      if (!more) return more.error();
      levels.add(*more);
    }
    probe.time = time_now() - start;
    probes.made.push_back(std::move(probe));
    return {};
  };
  const Status probed =
      for_probed_sequences({world_of, job.worlds.vary(), job.worlds.first_sequence()}, use);
  if (!probed) return probed.error();
  if (probes.made.empty()) {
    const std::uint32_t sequence = job.worlds.first_sequence();
    const Result<ReadyWorld> world = job.worlds.world(sequence);
    if (!world) return world.error();
    probes.made.push_back({{sequence, *world, {}}, {}, {}});
  }
  probes.limits_db = given_db ? *given_db : default_limits_db(std::move(levels));
  return probes;
}

// Of ping 0 with what its limits took, and of others.
struct PingToMake {
  const Pipeline& pipeline;
  std::uint32_t ping = 0;
  PingStart start;
};

struct MadePing {
  PingResult result;
  PingBytes bytes;
  std::uint64_t sequence_bytes = 0;
  std::size_t pings = 1;  // that were made in alone_s: draws of an ensemble are made together
  double alone_s = 0, store_s = 0, join_s = 0, list_s = 0;
};

// The polar image, which the table of objects needs, costs nothing where there are other images.
OutputSelection with_polar(OutputSelection output) {
  output.polar = output.polar || has_pictures(output);
  return output;
}

Result<ReadyPipeline> pipeline_of(const MeasureJob& job, Probe& probe,
                                  const std::array<double, 2>& limits_db) {
  const auto& [session, tracer] = probe.of.world;
  SequenceInfo info = sequence_info(*session, probe.of.sequence, 0,
                                    static_cast<std::uint32_t>(session->ping_times_s.size()));
  info.png.limits_db = limits_db;
  info.output = with_polar(info.output);
  Result<ReadyPipeline> ready = make_pipeline(*session, *tracer, std::move(info), job.numerics,
                                              Workers(job.threads), probe.shared, true);
  // make_pipeline takes ping 0 of sequence 0 only, since others may share its world.
  if (ready && probe.shared.ping_zero && !probe.shared.scene && probe.of.sequence != 0) {
    ready->ping_zero = std::move(*probe.shared.ping_zero);
  }
  return ready;
}

// What time series take that are added to the moments of an ensemble.
void add_to_moments(const SequenceInfo& info, SeriesBlock series) {
  if (!info.output.statistics) return;
  Moments moments(info.sonar.beam_count, info.record.samples);
  add_block(series, 0, 0, moments.beams, moments);
}

// Realizations that have no files, as many as are made at once. Returns their number.
std::size_t draw_pings(const Pipeline& pipeline, const Workers& workers) {
  const SequenceInfo& info = pipeline.info();
  const std::uint32_t pings = info.last_ping - info.first_ping;
  std::vector<Series> series(
      std::min({pings, kMomentBlock, static_cast<std::uint32_t>(pipeline.draws_at_once())}));
  pipeline.draws(info.first_ping, workers, series);
  add_to_moments(info, series);
  return series.size();
}

Status make_ping(const MeasureJob& job, const OutputSelection& output, PingToMake& task,
                 const Workers& workers, MadePing& made) {
  SequenceInfo info = task.pipeline.info();
  info.output = output;
  const bool is_drawn = output.statistics && !output.pings;
  Clock::time_point start = Clock::now();
  if (is_drawn) made.pings = draw_pings(task.pipeline, workers);
  made.result = is_drawn ? task.pipeline.frame(task.ping)
                         : task.pipeline.run(task.ping, workers, std::move(task.start));
  std::optional<LabelledImage> polar = std::exchange(made.result.polar, {});
  if (output.polar) made.result.polar.swap(polar);
  const Result<EncodedPing> encoded = encode_ping(info, made.result, workers);
  if (!output.polar) made.result.polar.swap(polar);
  if (!encoded) return encoded.error();
  made.result.scatterers = {};  // which `generate` does not keep either
  if (!is_drawn) add_to_moments(info, {&made.result.series, 1});
  made.alone_s = lap_s(start) / static_cast<double>(made.pings);
  // Nothing is stored of a realization that has no files.
  if (!is_drawn) store_unnamed(job, *encoded);
  made.store_s = lap_s(start);
  join_unnamed(job, *encoded);
  made.join_s = lap_s(start);
  const Result<PingBytes> bytes = ping_bytes(info, *encoded);
  if (!bytes) return bytes.error();
  made.list_s = lap_s(start);
  made.bytes = *bytes;
  made.sequence_bytes = sequence_bytes(info, *encoded);
  return {};
}

// `core_s`: of making all these pings.
void add_means(const std::vector<MadePing>& pings, double core_s, Measured& m) {
  const auto mean = [&](auto value) {
    double sum = 0;
    for (const MadePing& ping : pings) sum += static_cast<double>(value(ping));
    return sum / static_cast<double>(pings.size());
  };
  for (const MadePing& ping : pings) m.pings += ping.pings;
  m.store_s = mean([](const MadePing& p) { return p.store_s; });
  m.list_s = mean([](const MadePing& p) { return p.list_s; });
  const double join_s = mean([](const MadePing& p) { return p.join_s; });
  m.finish_s = join_s + kSequencePasses * m.list_s;
  const double lists_s = static_cast<double>(pings.size()) * (join_s + m.list_s);
  m.ping_s = std::max(0.0, (core_s - lists_s) / static_cast<double>(m.pings));
  m.alone_s += mean([](const MadePing& p) { return p.alone_s; });
  m.files = mean([](const MadePing& p) { return p.bytes.files; });
  m.piece = mean([](const MadePing& p) { return p.bytes.piece; });
  m.sequence_lines = mean([](const MadePing& p) { return p.bytes.sequence_lines; });
  m.dataset_lines = mean([](const MadePing& p) { return p.bytes.dataset_lines; });
  m.record = mean([](const MadePing& p) { return p.bytes.record; });
  m.sequence_bytes = mean([](const MadePing& p) { return p.sequence_bytes; });
}

// From the images of ping 0 or, if there are none, of one that is made for this.
Status look(const MeasureJob& job, const Pipeline& pipeline, const PingResult& ping_zero,
            LookedSequence& of) {
  const auto& [session, tracer] = of.world;
  if (ping_zero.polar) {
    of.objects = looks_at(*session, ping_zero, pipeline.info().noise_power_pa2);
    return {};
  }
  auto looks = look_at_objects(*session, *tracer, of.sequence, job.numerics, Workers(job.threads));
  if (!looks) return looks.error();
  of.objects = std::move(*looks);
  return {};
}

}  // namespace

Result<Measured> measure_pings(const MeasureJob& job) {
  const Session& first = job.worlds.first();
  Result<Probes> probes = probe_run(job);
  if (!probes) return probes.error();
  Measured m;
  m.sequences = probes->made.size();
  m.limits_db = probes->limits_db;
  const auto count = static_cast<double>(m.sequences);
  double core_s = 0;
  std::vector<ReadyPipeline> pipelines;
  for (Probe& probe : probes->made) {
    const RunTime start = time_now();
    Result<ReadyPipeline> ready = pipeline_of(job, probe, m.limits_db);
    if (!ready) return ready.error();
    pipelines.push_back(std::move(*ready));
    m.prepare_s += (time_now() - start).core_s / count;
    m.alone_s += probe.time.wall_s / count;
    core_s += probe.time.core_s;
  }
  if (m.sequences > 1) {
    m.world_s = probes->world_s;
    m.probe = probes->made.back().time + RunTime{m.world_s, m.world_s};
  }
  std::vector<PingToMake> tasks;
  for (ReadyPipeline& ready : pipelines) {
    tasks.push_back({ready.pipeline, 0, std::move(ready.ping_zero)});
  }
  const auto pings = static_cast<std::uint32_t>(first.ping_times_s.size());
  if (tasks.size() == 1 && pings > 1) tasks.push_back({pipelines[0].pipeline, pings - 1, {}});
  const int lanes = std::min(job.threads, static_cast<int>(tasks.size()));
  std::vector<MadePing> made(tasks.size());
  const RunTime start = time_now();
  const Status done = in_lanes(lanes, tasks.size(), [&](std::size_t, std::size_t i) {
    return make_ping(job, first.scenario.output.selection, tasks[i], Workers(job.threads / lanes),
                     made[i]);
  });
  if (!done) return done.error();
  add_means(made, core_s + (time_now() - start).core_s, m);
  for (std::size_t i = 0; i < pipelines.size(); ++i) {
    m.looked.push_back(std::move(probes->made[i].of));
    if (Status seen = look(job, pipelines[i].pipeline, made[i].result, m.looked.back()); !seen) {
      return seen.error();
    }
  }
  return m;
}

RunTime time_now() {
  return {std::chrono::duration<double>(Clock::now().time_since_epoch()).count(), process_core_s()};
}

RunTime time_of(const Measured& m, std::uint32_t sequences, std::uint32_t pings, bool vary,
                int threads) {
  const int lanes = sequences_under_way(threads, pings, sequences, vary);
  const double within = std::max(1, threads / lanes);
  const double worlds = vary ? sequences - 1 : 0;
  const double ping_s = m.ping_s + m.store_s;
  const double rest_s = worlds / sequences * m.world_s + m.prepare_s + pings * m.finish_s;
  // Pings are handed out one by one, so the last of them leave threads idle; a few share them all.
  const double pings_wall_s = pings < within
                                  ? std::max(m.alone_s + m.store_s, pings / within * ping_s)
                                  : std::ceil(pings / within) * ping_s;
  const double list_s = double(sequences) * pings * m.list_s;
  return {m.probe.wall_s + list_s + sequences * (rest_s + pings_wall_s) / std::min(lanes, threads),
          m.probe.core_s + list_s + sequences * (rest_s + pings * ping_s)};
}

}  // namespace ensonify
