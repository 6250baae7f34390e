// SEQUENCE.oculus: pings of version 2 with 8 or 16-bit amplitudes. The counts of recorded/ where
// these are amplitudes; otherwise the levels as 16-bit amplitudes whose largest is --full-scale-db.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "export/ping_values.h"
#include "formats/bytes.h"
#include "formats/files.h"
#include "recordings/oculus.h"

namespace ensonify {
namespace {

constexpr std::uint64_t kMostOculusCells = 65'535;  // beams or samples

// Whether recorded/ holds counts that a ping can have: its gamma is a multiple of 1/255.
bool has_oculus_counts(const StoredSequence& sequence) {
  const auto& recorder = sequence.manifest.info.recorder;
  if (!recorder || recorder->scale != GreyScale::amplitude) return false;
  const double steps = 255 * recorder->gamma;
  return recorder->gamma <= 1 && std::lround(steps) >= 1 &&
         std::abs(steps - std::round(steps)) < 1e-6;
}

// Gains are whole numbers in the file. Those of a recording are; others are scaled, which scales
// all amplitudes of the log.
double gain_scale(const SequenceInfo& info) {
  if (info.recording || !info.recorder) return 1;
  const double most = std::pow(10.0, info.recorder->row_gain_db / 10);
  return std::exp2(std::clamp(std::floor(32 - 1e-9 - std::log2(most)), 0.0, 16.0));
}

Result<OculusPing> oculus_ping_of(const StoredSequence& sequence, bool counts) {
  const SequenceInfo& info = sequence.manifest.info;
  if (sequence.beams < 2 || sequence.beams > kMostOculusCells || sequence.samples < 2 ||
      sequence.samples > kMostOculusCells) {
    return refused_sequence(
        sequence, fmt::format("{} beams of {} samples; a ping has 2 to {} of each", sequence.beams,
                              sequence.samples, kMostOculusCells));
  }
  if (sequence.first_range_m > 1e-3 * sequence.range_step_m) {
    return refused_sequence(sequence,
                            fmt::format("ranges begin at {:.3g} m; those of an Oculus begin at 0. "
                                        "Use --format aris",
                                        sequence.first_range_m));
  }
  OculusPing ping;
  const bool recorded = info.recording && info.recording->format == "oculus";
  ping.mode = recorded ? static_cast<std::uint8_t>(info.recording->mode) : std::uint8_t{2};
  ping.gamma = counts ? info.recorder->gamma : 1;
  ping.frequency_hz = info.sonar.frequency_hz;
  ping.sound_speed_m_s = info.water.sound_speed_m_s;
  ping.bytes_per_count = counts && info.recorder->bits == 8 ? 1 : 2;
  ping.range_step_m = sequence.range_step_m;
  ping.samples = static_cast<int>(sequence.samples);
  ping.beams = static_cast<int>(sequence.beams);
  for (int beam = ping.beams - 1; beam >= 0; --beam) {
    const double cdeg = -100 * degrees(beam_azimuth_rad(info.sonar, beam));
    const auto before =
        ping.bearing_cdeg.empty() ? -1e9 : static_cast<double>(ping.bearing_cdeg.back());
    if (!(std::abs(cdeg) <= 18'000) || std::round(cdeg) <= before) {
      return refused_sequence(
          sequence, "beams less than 0.01 degrees apart, which the log cannot tell apart");
    }
    ping.bearing_cdeg.push_back(static_cast<std::int16_t>(std::lround(cdeg)));
  }
  return ping;
}

std::uint16_t oculus_count_of(float level_db, double full_scale_db) {
  if (level_db <= kNoEnergyDb) return 0;
  const double share = std::pow(10.0, (level_db - full_scale_db) / 20);
  return static_cast<std::uint16_t>(std::lround(65'535 * std::min(share, 1.0)));
}

// Rows in the order of the message: port first.
std::string oculus_counts(const LogPing& cells, const OculusPing& ping, double full_scale_db) {
  const auto beams = static_cast<std::size_t>(ping.beams);
  std::string bytes;
  for (std::size_t row = 0; row < static_cast<std::size_t>(ping.samples); ++row) {
    for (std::size_t beam = beams; beam-- > 0;) {
      const std::size_t i = row * beams + beam;
      const std::uint16_t count = cells.counts.empty()
                                      ? oculus_count_of(cells.level_db[i], full_scale_db)
                                      : cells.counts[i];
      if (ping.bytes_per_count == 1) {
        bytes += static_cast<char>(count);
      } else {
        put_value(bytes, count);
      }
    }
  }
  return bytes;
}

Status write_oculus_sequence(const ExportJob& job, const std::filesystem::path& path,
                             const StoredSequence& sequence) {
  const bool counts = has_oculus_counts(sequence);
  auto ping = oculus_ping_of(sequence, counts);
  if (!ping) return ping.error();
  const auto full_scale_db = counts ? Result<double>(0.0) : full_scale_of(job, sequence);
  if (!full_scale_db) return full_scale_db.error();
  const SequenceInfo& info = sequence.manifest.info;
  const double scale = gain_scale(info);
  StreamedFile file(path);
  file.append(
      oculus_file_header(info.recording ? static_cast<double>(info.recording->start_us) / 1e6 : 0));
  const Status read =
      for_each_exported_ping(job, sequence, [&](const StoredPing& stored) -> Status {
        auto cells = log_ping_of(job, sequence, stored.ping, counts);
        if (!cells) return cells.error();
        for (float& gain : cells->row_gain) gain = std::round(static_cast<float>(gain * scale));
        ping->attitude = attitude_of(stored.sonar_in_world);
        ping->start_s = stored.time_s;
        const double time_s = static_cast<double>(log_time_us(sequence, stored)) / 1e6;
        file.append(oculus_ping_item(*ping, stored.ping, time_s,
                                     oculus_counts(*cells, *ping, *full_scale_db),
                                     cells->row_gain));
        return {};
      });
  return read ? file.close() : read;
}

}  // namespace

Status write_oculus(const ExportJob& job, const std::filesystem::path& target) {
  return for_each_sequence(job, [&](const StoredSequence& sequence) {
    return write_oculus_sequence(job, target / fmt::format("{:06}.oculus", sequence.row.sequence),
                                 sequence);
  });
}

}  // namespace ensonify
