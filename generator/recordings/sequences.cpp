#include "recordings/sequences.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/counted.h"
#include "core/units.h"
#include "formats/bytes.h"
#include "instrument/recorder.h"
#include "labels/cartesian.h"

namespace ensonify {
namespace {

constexpr double kMostRowGain_db = 96.33;           // of 32 bits
constexpr std::size_t kMostLogSequences = 100'000;  // each keeps its settings in memory

class Surveyor {
 public:
  Surveyor(const Log& log, const std::optional<std::pair<std::uint32_t, std::uint32_t>>& frames)
      : log_(log) {
    if (!frames) return;
    first_ = frames->first;
    last_ = frames->second;
  }

  bool wants_counts(std::uint64_t frame) const { return frame == first_; }

  Status add(std::uint64_t number, const LogFrame& frame) {
    if (number < first_ || number >= last_) return {};
    if (frame.settings.bits > 16) {
      return Error{ErrorKind::usage,
                   fmt::format("{}: frame {}: counts of 32 bits; record with 8 or 16 bits, which "
                               "data sets hold",
                               log_.name, number)};
    }
    if (number == first_) found.first_level_db = log_levels_db(frame);
    auto& sequences = found.sequences;
    const bool follows = !sequences.empty() && sequences.back().serial == frame.serial &&
                         same_sequence(sequences.back().settings, frame.settings) &&
                         sequences.back().frames() < kMaxPings;
    falls_ = falls_ || (follows && frame.time_us < last_us_);
    last_us_ = frame.time_us;
    if (!follows) {
      if (sequences.size() >= kMostLogSequences) {
        return Error{ErrorKind::usage,
                     fmt::format("{}: frame {}: more than {} sequences, because the settings "
                                 "change so often; choose a part of the frames with --pings",
                                 log_.name, number, kMostLogSequences)};
      }
      sequences.push_back({frame.settings, number, number, frame.time_us, frame.serial});
    }
    ++sequences.back().last_frame;
    return {};
  }

  Status end(const LogEnd& end) {
    found.frames = end.frames;
    if (!end.warning.empty()) found.warnings.push_back(end.warning);
    if (falls_) {
      found.warnings.push_back(log_.name + ": times of frames fall; they are kept as they are");
    }
    const bool inside = first_ < end.frames && (last_ == kAll || last_ <= end.frames);
    if (inside && first_ < last_) return {};
    return Error{ErrorKind::usage,
                 fmt::format("--pings {}:{}: the log has frames 0 to {}; expected A:B with 0 <= A "
                             "< B <= {}",
                             first_, last_, end.frames - 1, end.frames)};
  }

  LogSurvey found;

 private:
  static constexpr std::uint64_t kAll = std::numeric_limits<std::uint64_t>::max();

  const Log& log_;
  std::uint64_t first_ = 0, last_ = kAll;
  std::int64_t last_us_ = 0;
  bool falls_ = false;
};

double count_at(const LogFrame& frame, std::size_t i) {
  if (frame.settings.bits == 8) return value_at<std::uint8_t>(frame.counts, i);
  return value_at<std::uint16_t>(frame.counts, 2 * i);
}

Sonar sonar_of(const LogSettings& settings) {
  Sonar sonar;
  sonar.frequency_hz = settings.frequency_hz;
  // The inverse of the sample interval, from which readers compute it.
  sonar.bandwidth_hz = 1 / (2 * settings.range_step_m / settings.sound_speed_m_s);
  sonar.first_range_m = settings.first_range_m;
  sonar.range_min_m = settings.first_range_m;
  sonar.range_max_m = settings.first_range_m + (settings.samples - 1) * settings.range_step_m;
  sonar.beam_count = settings.beams;
  sonar.azimuth_rad = settings.azimuth_rad;
  sonar.beam_spacing_rad =
      (settings.azimuth_rad.back() - settings.azimuth_rad.front()) / (settings.beams - 1);
  return sonar;
}

}  // namespace

Result<LogSurvey> survey_log(const Log& log,
                             const std::optional<std::pair<std::uint32_t, std::uint32_t>>& frames,
                             const std::function<bool()>& stop) {
  Surveyor surveyor(log, frames);
  const auto end =
      log.read({[&](std::uint64_t frame) { return surveyor.wants_counts(frame); },
                [&](std::uint64_t number, const LogFrame& frame) -> Status {
                  if (stop && stop()) {
                    return Error{ErrorKind::interrupted, "interrupted; nothing was written"};
                  }
                  return surveyor.add(number, frame);
                }});
  if (!end) return end.error();
  if (const Status ended = surveyor.end(*end); !ended) return ended.error();
  return std::move(surveyor.found);
}

Recorder recorder_of(const LogSettings& settings) {
  Recorder recorder;
  recorder.bits = settings.bits;
  if (settings.db) {
    recorder.scale = GreyScale::db;
    recorder.db = *settings.db;
    return recorder;
  }
  recorder.scale = GreyScale::amplitude;
  recorder.gamma = settings.gamma;
  // Every level must be above that of no energy.
  const double span_db = 20 / settings.gamma * std::log10(std::ldexp(1.0, settings.bits) - 1);
  recorder.row_gain_db = settings.row_gains ? kMostRowGain_db : 0;
  const double lowest_db = -span_db - recorder.row_gain_db;
  const double full_scale_db = std::max(0.0, std::ceil(kNoEnergyDb + 1 - lowest_db));
  recorder.db = {full_scale_db - span_db, full_scale_db};
  return recorder;
}

SequenceInfo recording_info(const LogSource& source, const LogSequence& sequence,
                            std::uint32_t number, int height_px) {
  const LogSettings& settings = sequence.settings;
  SequenceInfo info;
  info.sequence = number;
  info.split = "train";
  info.sonar = sonar_of(settings);
  info.water.sound_speed_m_s = settings.sound_speed_m_s;
  info.record.samples = settings.samples;
  info.record.sample_interval_s = 2 * settings.range_step_m / settings.sound_speed_m_s;
  info.recorder = recorder_of(settings);
  info.output = {.timeseries = false, .shadow = false, .amodal = false, .labels = false};
  info.cartesian = cartesian_grid(info.sonar, height_px);
  info.last_ping = static_cast<std::uint32_t>(sequence.frames());
  info.recording = {log_format_name(source.format),
                    source.name,
                    source.sha256,
                    settings.instrument,
                    sequence.serial,
                    settings.mode,
                    sequence.first_frame,
                    sequence.start_us};
  return info;
}

std::vector<float> log_levels_db(const LogFrame& frame) {
  const Recorder recorder = recorder_of(frame.settings);
  const auto beams = static_cast<std::size_t>(frame.settings.beams);
  const auto samples = static_cast<std::size_t>(frame.settings.samples);
  std::vector<double> of_count;  // without a row gain; empty: images smaller than the table
  const double counts = std::ldexp(1.0, recorder.bits);
  if (static_cast<double>(beams * samples) >= counts) {
    for (double count = 0; count < counts; ++count) {
      of_count.push_back(recorded_level_db(recorder, count, 1));
    }
  }
  const auto level_of = [&](double count) {
    return of_count.empty() ? recorded_level_db(recorder, count, 1)
                            : of_count[static_cast<std::size_t>(count)];
  };
  std::vector<float> levels(beams * samples, kNoEnergyDb);
  for (std::size_t sample = 0; sample < samples; ++sample) {
    const double gain = frame.row_gain.empty() ? 1 : double{frame.row_gain[sample]};
    if (!(gain > 0)) continue;
    const double gain_db = 10 * std::log10(gain);
    for (std::size_t i = sample * beams; i < (sample + 1) * beams; ++i) {
      const double count = count_at(frame, i);
      if (count <= 0 && recorder.scale == GreyScale::amplitude) continue;
      levels[i] = std::max(static_cast<float>(level_of(count) - gain_db), kNoEnergyDb);
    }
  }
  round_to_halves(levels);
  return levels;
}

Pose pose_of(const LogFrame& frame) {
  if (frame.sonar_in_world) return *frame.sonar_in_world;
  Pose pose;
  if (frame.attitude) {
    const LogAttitude& attitude = *frame.attitude;
    // Positive pitch is nose down there.
    pose.rotation = from_roll_pitch_yaw(radians(attitude.roll_deg), -radians(attitude.pitch_deg),
                                        radians(90 - attitude.heading_deg));
  }
  if (frame.depth_m) pose.position_m.z = -*frame.depth_m;
  return pose;
}

RecordedDisplay recorded_display(const SequenceInfo& info) {
  RecordedDisplay display{display_table(info.png, 0, range_step_m(info.sonar, info.water),
                                        info.record.samples, info.sonar.first_range_m),
                          cartesian_map(*info.cartesian, info.sonar, info.water, info.record),
                          {}};
  display.footprints =
      footprints(*info.cartesian, info.sonar, info.water, info.record, display.map);
  return display;
}

PingResult recorded_result(const SequenceInfo& info, const RecordedDisplay& display,
                           const LogFrame& frame, std::uint32_t ping) {
  PingResult result;
  result.ping = ping;
  result.time_s = static_cast<double>(frame.time_us - info.recording->start_us) / 1e6;
  result.sonar_in_world = pose_of(frame);
  if (frame.settings.bits == 8) {
    result.recorded.counts_8 = values_in<std::uint8_t>(frame.counts);
  } else {
    result.recorded.counts_16 = values_in<std::uint16_t>(frame.counts);
  }
  result.recorded.row_gain = frame.row_gain;
  LabelledImage& polar = result.polar.emplace();
  polar.rows = info.record.samples;
  polar.columns = info.sonar.beam_count;
  polar.level_db = log_levels_db(frame);
  DisplayedImage shown = displayed(display.table, polar.rows, polar.columns, polar.level_db, {});
  result.grey_counts = shown.counts;
  result.cartesian_grey = displayed_cartesian(display.table, display.footprints, {},
                                              shown.further_gain_db, polar.level_db);
  result.polar_grey = std::move(shown.grey);
  result.first_return_m.assign(static_cast<std::size_t>(info.sonar.beam_count),
                               std::numeric_limits<float>::quiet_NaN());
  return result;
}

}  // namespace ensonify
