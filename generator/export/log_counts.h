// What both logs of instruments are made from. Private to export/.
//
//   LogPing  log_ping_of   the counts or the levels of a ping
//   attitude_of            heading, pitch and roll of a pose
//   log_time_us            the time of a ping on the clock of its log
//   full_scale_of          the level of the largest count
//   refused_sequence       the Error for a sequence that a log cannot hold
#pragma once

#include <cstdint>
#include <vector>

#include "export/job.h"
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

}  // namespace ensonify
