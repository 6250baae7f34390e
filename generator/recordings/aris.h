// The .aris files of Sound Metrics' ARIS sonars: a file header of 1024 bytes, then for each frame a
// header of 1024 bytes and [samples x beams] bytes, 0 to 255 for 0 to 80 dB. Beam 0 of the file is
// the one on the right. Little-endian, no padding.
//
// Layout, ranges and beam tables: Sound Metrics, aris-file-sdk (MIT), commit 8c7bb21,
// type-definitions/C/FrameHeader.h, docs/understanding-aris-data.md, beam-width-metrics/.
//
//   is_aris  is_didson                  by the first four bytes
//   ArisHead  parse_aris_head           the members of a frame header that are used
//   aris_beams  aris_frequency_hz       what follows from ping mode and model
//   aris_azimuths_deg                   centers of the beams, beam 0 first
//   read_aris                           frame by frame
//   aris_file_header  aris_frame_header for writers
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "recordings/log.h"

namespace ensonify {

inline constexpr std::uint64_t kArisHeader = 1024;  // bytes, of the file and of a frame
inline constexpr double kArisSpan_db = 80;          // of the counts 0 to 255

bool is_aris(std::string_view bytes);
bool is_didson(std::string_view bytes);

// Systems by their number in the file.
inline constexpr std::uint32_t kAris1800 = 0, kAris3000 = 1, kAris1200 = 2;

struct ArisHead {
  std::uint32_t frame = 0;
  std::int64_t time_us = 0;  // of the sonar's clock since 1970; of the recorder's, if it has none
  std::uint32_t ping_mode = 0, high_frequency = 0, samples = 0;
  std::uint32_t sample_period_us = 0, sample_start_us = 0;
  float sound_speed_m_s = 0;
  std::uint32_t large_lens = 0, system = 0, serial = 0, reordered = 1;
  float depth_m = 0;
  float heading_deg = 0, pitch_deg = 0, roll_deg = 0;  // of the platform; of the compass, if 0
};

// Needs kArisHeader bytes. `offset`: of the header in the log. Error (usage): another signature,
// unordered samples, or numbers that no frame can have.
Result<ArisHead> parse_aris_head(const LogBytes& log, std::uint64_t offset, std::string_view bytes);

// Beams of a ping mode; 0: unknown.
int aris_beams(std::uint32_t ping_mode);
double aris_frequency_hz(std::uint32_t system, bool high);

// Empty: no published table for this lens and number of beams.
std::span<const double> aris_azimuths_deg(std::uint32_t system, int beams, bool large_lens);

Result<LogEnd> read_aris(const LogBytes& log, const LogFrames& frames);

// What the layout asks of writers.
std::string aris_file_header(const ArisHead& first, std::uint32_t frames);
std::string aris_frame_header(const ArisHead& head);

}  // namespace ensonify
