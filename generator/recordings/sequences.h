// The sequences of a log, and their pings as a data set stores them.
//
//   LogSequence  LogSurvey  survey_log   runs of frames with the same settings
//   recorder_of  recording_info          what sequence.json holds of them
//   recorded_result                      one frame as the files of a ping
//   log_levels_db                        the levels that its counts stand for
//   pose_of                              the sonar in the world
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/ping.h"
#include "labels/cartesian_display.h"
#include "labels/display.h"
#include "recordings/log.h"

namespace ensonify {

// `name`: of the log; `sha256`: of its content.
struct LogSource {
  LogFormat format = LogFormat::aris;
  std::string name, sha256;
};

struct LogSequence {
  LogSettings settings;
  std::uint64_t first_frame = 0, last_frame = 0;  // of the log, [first, last)
  std::int64_t start_us = 0;                      // the time of the first one
  std::uint64_t serial = 0;

  std::uint64_t frames() const { return last_frame - first_frame; }
};

struct LogSurvey {
  std::vector<LogSequence> sequences;
  std::vector<float> first_level_db;  // of the first frame
  std::uint64_t frames = 0;           // of the whole log
  std::vector<std::string> warnings;  // the log is cut off, or its times fall
};

// `frames`: [first, last) of those that are used; absent: all. Reads the whole log, and counts of
// the first frame only. Errors: those of read_log; (usage) none of these frames is in the log, a
// frame has counts of 32 bits, more than 100,000 sequences; `stop` returned true (interrupted).
Result<LogSurvey> survey_log(const Log& log,
                             const std::optional<std::pair<std::uint32_t, std::uint32_t>>& frames,
                             const std::function<bool()>& stop);

// Amplitudes: full scale is 0 dB, or so many whole dB more that all levels are above kNoEnergyDb.
Recorder recorder_of(const LogSettings& settings);

// Without limits of 8-bit images. `height_px`: of Cartesian images.
SequenceInfo recording_info(const LogSource& source, const LogSequence& sequence,
                            std::uint32_t number, int height_px);

// [samples x beams] by `recorder_of`; kNoEnergyDb for an amplitude or a row gain of 0. Rounded to
// halves, as files hold them.
std::vector<float> log_levels_db(const LogFrame& frame);

// World axes: x east, y north, z up. Without an attitude the sonar looks along x.
Pose pose_of(const LogFrame& frame);

// What the pings of a sequence share.
struct RecordedDisplay {
  DisplayTable table;
  std::vector<std::int32_t> map;
  Footprints footprints;
};
RecordedDisplay recorded_display(const SequenceInfo& info);

PingResult recorded_result(const SequenceInfo& info, const RecordedDisplay& display,
                           const LogFrame& frame, std::uint32_t ping);

}  // namespace ensonify
