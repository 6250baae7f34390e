#include "run/simulate_pings.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <utility>

#include "formats/bytes.h"
#include "instrument/recorder.h"
#include "ping/ping_series.h"
#include "run/live_sequence.h"

namespace ensonify {
namespace {

// Series alone: neither labels nor expected levels are computed.
constexpr const char* kOutput =
    "{timeseries: npy, polar: false, cartesian: false, png: false, shadow: false, amodal: false}";

template <class Count>
std::vector<float> amplitudes_of_counts(const Recorder& recorder, const std::vector<Count>& counts,
                                        const std::vector<float>& row_gain, std::size_t beams) {
  std::vector<float> amplitudes;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double gain = row_gain.empty() ? 1 : row_gain[i / beams];
    amplitudes.push_back(recorded_amplitude(recorder, counts[i], gain));
  }
  return amplitudes;
}

std::vector<float> amplitudes_of(const SequenceInfo& info, const PingResult& ping,
                                 const std::optional<Recorder>& reader) {
  const auto beams = static_cast<std::size_t>(info.sonar.beam_count);
  const RecordedPing& recorded = ping.recorded;
  if (!info.recorder) {
    std::vector<float> values(ping.detected_db.begin(), ping.detected_db.end());
    if (!info.sonar.detector) values = polar_levels_db(ping.series, beams);
    round_to_halves(values);  // as files hold them
    for (float& value : values) value = amplitude_of_level(value);
    return values;
  }
  const bool read_alike =
      reader && reader->bits == info.recorder->bits && reader->scale == info.recorder->scale;
  const Recorder& recorder = read_alike ? *reader : *info.recorder;
  return recorder.bits == 8
             ? amplitudes_of_counts(recorder, recorded.counts_8, recorded.row_gain, beams)
             : amplitudes_of_counts(recorder, recorded.counts_16, recorded.row_gain, beams);
}

void add_axes(const SequenceInfo& info, PolarPings& pings) {
  for (int n = 0; n < info.record.samples; ++n) {
    pings.range_m.push_back(sample_range_m(info.sonar, info.water, n));
  }
  pings.azimuth_rad = beam_azimuths_rad(info.sonar);
}

bool has_axes(const SequenceInfo& info, const PolarPings& pings) {
  return pings.samples() == info.record.samples && pings.beams() == info.sonar.beam_count &&
         pings.range_m.back() == sample_range_m(info.sonar, info.water, pings.samples() - 1) &&
         pings.azimuth_rad == beam_azimuths_rad(info.sonar);
}

struct RunMaker {
  const LiveSequence& sequence;
  const std::optional<Recorder>& reader;
  const Workers& workers;
  bool (*stop)();
};

Status add_runs(const RunMaker& maker, std::span<const PingRun> runs, std::uint32_t block,
                PolarPings& pings) {
  std::vector<std::uint32_t> numbers;
  for (const PingRun& run : runs) {
    for (std::uint32_t ping = run.first; ping < run.first + run.count; ++ping) {
      numbers.push_back(ping);
      pings.block.push_back(block);
    }
    ++block;
  }
  const std::size_t first = pings.amplitude.size();
  pings.amplitude.resize(first + numbers.size());
  pings.time_s.resize(first + numbers.size());
  std::atomic<bool> stopped = false;
  maker.workers.for_each(numbers.size(), [&](std::size_t i) {
    if (maker.stop != nullptr && maker.stop()) stopped = true;
    if (stopped) return;
    const PingResult ping = live_ping(maker.sequence, numbers[i], Workers(1));
    pings.amplitude[first + i] = amplitudes_of(*maker.sequence.info, ping, maker.reader);
    pings.time_s[first + i] = ping.time_s;
  });
  if (stopped) return Error{ErrorKind::interrupted, "interrupted"};
  return {};
}

}  // namespace

Result<PolarPings> simulate_pings(const SimulateWish& wish, const Workers& workers) {
  ScenarioOptions only_series = wish.input;
  only_series.overrides.push_back({"output", kOutput});
  const auto source = open_source(only_series, BackendChoice::automatic);
  if (!source) return source.error();
  const Scenario& scenario = (*source)->worlds.first().scenario;
  std::vector<PingRange> sequences;
  for (std::uint32_t s = 0; s < scenario.sequences; ++s) {
    const auto info = (*source)->worlds.info(s, {});
    if (!info) return info.error();
    sequences.emplace_back(info->first_ping, info->last_ping);
  }
  const std::vector<PingRun> runs = ping_runs(sequences, wish.amount);
  PolarPings pings;
  for (std::size_t r = 0; r < runs.size();) {
    const auto same = [&](const PingRun& run) { return run.sequence == runs[r].sequence; };
    const auto end =
        std::find_if_not(runs.begin() + static_cast<std::ptrdiff_t>(r), runs.end(), same);
    const auto sequence = open_sequence(**source, static_cast<std::uint32_t>(runs[r].sequence),
                                        scenario.output.selection, workers);
    if (!sequence) return sequence.error();
    const SequenceInfo& info = *(*sequence)->info;
    if (pings.range_m.empty()) add_axes(info, pings);
    pings.from_counts = info.recorder.has_value();
    if (!has_axes(info, pings)) {
      return Error{ErrorKind::usage,
                   "the sequences have different ranges or azimuths; expected one sonar in all"};
    }
    const auto count = static_cast<std::size_t>(end - runs.begin()) - r;
    const Status added =
        add_runs({**sequence, wish.reader, workers, wish.stop}, std::span(runs).subspan(r, count),
                 static_cast<std::uint32_t>(r), pings);
    if (!added) return added.error();
    r += count;
  }
  return pings;
}

}  // namespace ensonify
