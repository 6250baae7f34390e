// SEQUENCE.aris: 8-bit counts, 0 to 255 for 0 to 80 dB. The counts of recorded/ where these have
// the same scale; otherwise the levels up to --full-scale-db. Azimuths are not in the file: they
// follow from the model and the number of beams, so that the fan must be close to a published one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.h"
#include "export/ping_values.h"
#include "formats/files.h"
#include "recordings/aris.h"

namespace ensonify {
namespace {

constexpr double kTableSlack_beams = 1;  // between an azimuth and that of the table

struct ArisModel {
  std::uint32_t system = kAris3000, large_lens = 0;
  const char* name = "";  // as settings_of in recordings/aris.cpp
};
constexpr ArisModel kModels[] = {{kAris3000, 0, "ARIS 3000"},
                                 {kAris1800, 0, "ARIS 1800"},
                                 {kAris1200, 0, "ARIS 1200"},
                                 {kAris3000, 1, "ARIS 3000 with telephoto lens"},
                                 {kAris1800, 1, "ARIS 1800 with telephoto lens"},
                                 {kAris1200, 1, "ARIS 1200 with telephoto lens"}};

// The largest distance of an azimuth from the table's, in beams; infinite without a table.
double distance_of(const ArisModel& model, const Sonar& sonar) {
  const auto table = aris_azimuths_deg(model.system, sonar.beam_count, model.large_lens != 0);
  double largest = table.empty() ? std::numeric_limits<double>::infinity() : 0;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double azimuth = beam_azimuth_rad(sonar, static_cast<int>(i));
    largest = std::max(largest, std::abs(azimuth - radians(table[i])) / sonar.beam_spacing_rad);
  }
  return largest;
}

// The one that was recorded, or the one with the nearest fan and frequency.
Result<ArisModel> model_of(const StoredSequence& sequence) {
  const SequenceInfo& info = sequence.manifest.info;
  const int beams = info.sonar.beam_count;
  if (beams != 48 && beams != 64 && beams != 96 && beams != 128) {
    return refused_sequence(sequence,
                            fmt::format("{} beams; an ARIS has 48, 64, 96 or 128. Use --format "
                                        "oculus, or generate with one of these numbers",
                                        beams));
  }
  ArisModel best;
  double distance = std::numeric_limits<double>::infinity();
  for (const ArisModel& model : kModels) {
    const double of_model = distance_of(model, info.sonar);
    const bool recorded = info.recording && info.recording->format == "aris" &&
                          info.recording->instrument == model.name;
    if (recorded && of_model <= kTableSlack_beams) return model;
    if (of_model < distance) {
      best = model;
      distance = of_model;
    }
  }
  if (distance <= kTableSlack_beams) return best;
  return refused_sequence(
      sequence, fmt::format("its beams differ by {:.1f} beams from those of {} with {} beams, the "
                            "nearest sonar; an .aris file has no azimuths. Use --format oculus",
                            distance, best.name, beams));
}

std::uint32_t ping_mode_of(const SequenceInfo& info) {
  const bool recorded = info.recording && info.recording->format == "aris";
  if (recorded && aris_beams(info.recording->mode) == info.sonar.beam_count) {
    return info.recording->mode;
  }
  switch (info.sonar.beam_count) {
    case 48:
      return 1;
    case 96:
      return 3;
    case 64:
      return 6;
    default:
      return 9;
  }
}

// The sample period is a whole number of microseconds: the sound speed takes up the rest, so that
// the ranges are right.
Result<ArisHead> head_of(const StoredSequence& sequence) {
  const auto model = model_of(sequence);
  if (!model) return model.error();
  const SequenceInfo& info = sequence.manifest.info;
  ArisHead head;
  head.system = model->system;
  head.large_lens = model->large_lens;
  head.ping_mode = ping_mode_of(info);
  head.samples = static_cast<std::uint32_t>(sequence.samples);
  const double low = aris_frequency_hz(head.system, false);
  const double high = aris_frequency_hz(head.system, true);
  head.high_frequency =
      std::abs(info.sonar.frequency_hz - high) <= std::abs(info.sonar.frequency_hz - low);
  const double two_way_us = 2e6 / info.water.sound_speed_m_s;  // of a meter
  const double period_us = std::max(1.0, std::round(sequence.range_step_m * two_way_us));
  const double speed_m_s = 2e6 * sequence.range_step_m / period_us;
  if (!(speed_m_s >= 1000 && speed_m_s <= 2000) || sequence.samples > kMostLogSamples) {
    return refused_sequence(
        sequence, fmt::format("samples of {:.3g} m; an ARIS has a whole number of microseconds "
                              "from one to the next, and at most {} samples. Use --format oculus",
                              sequence.range_step_m, kMostLogSamples));
  }
  head.sample_period_us = static_cast<std::uint32_t>(period_us);
  head.sound_speed_m_s = static_cast<float>(speed_m_s);
  head.sample_start_us =
      static_cast<std::uint32_t>(std::lround(sequence.first_range_m * 2e6 / speed_m_s));
  if (info.recording) head.serial = static_cast<std::uint32_t>(info.recording->serial);
  return head;
}

// Whether recorded/ holds counts of this scale.
bool has_aris_counts(const StoredSequence& sequence) {
  const auto& recorder = sequence.manifest.info.recorder;
  return recorder && recorder->bits == 8 && recorder->scale == GreyScale::db &&
         std::abs(recorder->db[1] - recorder->db[0] - kArisSpan_db) < 1e-9;
}

std::string aris_counts(const LogPing& ping, double full_scale_db) {
  std::string bytes;
  for (const std::uint16_t count : ping.counts) bytes += static_cast<char>(count);
  for (const float level_db : ping.level_db) {
    const double share = (level_db - full_scale_db) / kArisSpan_db + 1;
    bytes += static_cast<char>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
  }
  return bytes;
}

Status write_aris_sequence(const ExportJob& job, const std::filesystem::path& path,
                           const StoredSequence& sequence) {
  auto head = head_of(sequence);
  if (!head) return head.error();
  const bool counts = has_aris_counts(sequence);
  const auto full_scale_db = counts ? Result<double>(0.0) : full_scale_of(job, sequence);
  if (!full_scale_db) return full_scale_db.error();
  StreamedFile file(path);
  file.append(aris_file_header(*head, static_cast<std::uint32_t>(sequence.row.pings())));
  const Status read = for_each_exported_ping(job, sequence, [&](const StoredPing& ping) -> Status {
    const auto cells = log_ping_of(job, sequence, ping.ping, counts);
    if (!cells) return cells.error();
    const LogAttitude attitude = attitude_of(ping.sonar_in_world);
    const std::int64_t time_us = log_time_us(sequence, ping);
    if (time_us < 0) {
      return refused_sequence(
          sequence, fmt::format("ping {} is at {} s; a frame has no negative time, so begin the "
                                "trajectory at 0 or later",
                                ping.ping, ping.time_s));
    }
    head->time_us = time_us;
    head->depth_m = static_cast<float>(-ping.sonar_in_world.position_m.z);
    head->heading_deg = static_cast<float>(attitude.heading_deg);
    head->pitch_deg = static_cast<float>(attitude.pitch_deg);
    head->roll_deg = static_cast<float>(attitude.roll_deg);
    file.append(aris_frame_header(*head));
    file.append(aris_counts(*cells, *full_scale_db));
    ++head->frame;
    return {};
  });
  return read ? file.close() : read;
}

}  // namespace

Status write_aris(const ExportJob& job, const std::filesystem::path& target) {
  return for_each_sequence(job, [&](const StoredSequence& sequence) {
    return write_aris_sequence(job, target / fmt::format("{:06}.aris", sequence.row.sequence),
                               sequence);
  });
}

}  // namespace ensonify
