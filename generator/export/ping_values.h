// What several formats take from a ping, as they write it. Private to export/.
//
//   LogPing  log_ping_of   the counts or the levels
//   full_scale_of          the level of the largest count
//   DatasetScale  scale_of_dataset  scaled_amplitudes   amplitudes with one gain for a data set
//   StoredScatterer  scatterer_at      a scatterer of scatterers/*.npy
//   attitude_of            heading, pitch and roll of a pose
//   matrix_of              a pose as a 4 x 4 matrix
//   log_time_us            the time on the clock of a log
//   equal_beams            whether an azimuth is linear in the column
//   refused_sequence       the Error for a sequence that a format cannot hold
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/vec.h"
#include "dataset/echo_arrays.h"
#include "export/job.h"
#include "formats/bytes.h"
#include "recordings/log.h"

namespace ensonify {

struct LogPing {
  std::vector<std::uint16_t> counts;  // [samples x beams], recorded; empty: not asked for
  std::vector<float> row_gain;        // [samples]; empty: none
  std::vector<float> level_db;        // [samples x beams]; empty: counts were asked for
};

// With `counts` those of recorded/, otherwise the levels. Error (usage): the data set lacks them.
Result<LogPing> log_ping_of(const ExportJob& job, const StoredSequence& sequence,
                            std::uint32_t ping, bool counts);

LogAttitude attitude_of(const Pose& pose);

std::int64_t log_time_us(const StoredSequence& sequence, const StoredPing& ping);

// --full-scale-db, or else the level that is white in the 8-bit images unless their gain varies, or
// else the largest level of the sequence's first ping, rounded up.
Result<double> full_scale_of(const ExportJob& job, const StoredSequence& sequence);

// Usage; "sequence N: WHAT".
Error refused_sequence(const StoredSequence& sequence, const std::string& what);

// The level that becomes 1: full_scale_of the first exported sequence.
struct DatasetScale {
  double full_scale_db = 0;
};
Result<DatasetScale> scale_of_dataset(const ExportJob& job);

// [samples x beams], 10^((level - full scale) / 20), at most 1. Errors: those of log_ping_of.
Result<std::vector<float>> scaled_amplitudes(const ExportJob& job, const StoredSequence& sequence,
                                             std::uint32_t ping, const DatasetScale& scale);

// Row-major, from the sonar's frame to the world.
std::array<double, 16> matrix_of(const Pose& pose);

// Error (usage): beams that are not equally spaced.
Status equal_beams(const StoredSequence& sequence);

struct StoredScatterer {
  Vec3 in_world;
  double intensity = 0;  // |amplitude gain|^2: the squared pressure for a source of 1 Pa m
  std::uint32_t instance = 0;
};

// Needs kScattererBytes bytes (dataset/echo_arrays.h).
inline StoredScatterer scatterer_at(std::string_view bytes) {
  constexpr std::size_t kAmplitude = 20, kGain = 40, kInstance = 52, kPosition = 58;
  const double re = value_at<float>(bytes, kAmplitude);
  const double im = value_at<float>(bytes, kAmplitude + sizeof(float));
  const double gain = value_at<float>(bytes, kGain);
  const auto place = [&](std::size_t axis) {
    return value_at<double>(bytes, kPosition + axis * sizeof(double));
  };
  return {{place(0), place(1), place(2)},
          (re * re + im * im) * gain * gain,
          value_at<std::uint32_t>(bytes, kInstance)};
}

}  // namespace ensonify
