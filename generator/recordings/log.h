// What the logs of all real sonars have in common, and their bytes without holding them in memory.
// open_log.h opens one.
//
//   LogBytes  memory_log  file_log    the bytes of a log, read piece by piece
//   LogSettings  same_sequence        what the frames of a sequence share
//   LogFrame                          one ping with its counts
//   LogFormat  LogFrames              which frames are read, and what is done with them
//   LogChoices                        what a log leaves open
//   Log                               one of any format
//   log_error                         an Error at a byte of the log
//
// Counts are those of the instrument, bit by bit. Beams are ordered as in a data set: beam 0 to
// starboard, with the most negative azimuth.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/vec.h"

namespace ensonify {

struct LogBytes {
  std::string name;  // for messages
  std::uint64_t size = 0;
  // Needs offset + count <= size. Error (io): the log cannot be read, or has become shorter.
  std::function<Result<std::string>(std::uint64_t offset, std::uint64_t count)> read;
};

// `bytes` must outlive the result.
LogBytes memory_log(std::string name, std::string_view bytes);
// Error (io): the file cannot be opened.
Result<LogBytes> file_log(const std::filesystem::path& path);

struct LogSettings {
  std::string instrument;  // "ARIS 1200", or what the log says of an Oculus
  std::uint32_t mode = 0;  // the instrument's number of it
  int beams = 0, samples = 0;
  int bits = 8;            // of a count: 8, 16 or 32
  bool row_gains = false;  // amplitude = count / sqrt(gain of the sample)
  // Counts are linear in dB, from 0 to full scale between these levels; absent: they are a power of
  // the amplitude.
  std::optional<std::array<double, 2>> db = {};
  double gamma = 1;  // ... this power
  double frequency_hz = 0;
  double sound_speed_m_s = 0;
  double first_range_m = 0, range_step_m = 0;
  std::vector<double> azimuth_rad;  // [beams], rising
};

// Whether a frame with settings `b` may follow one with settings `a` in a sequence: everything is
// equal, except that the ranges may differ by half a sample at most, as the sound speed drifts.
bool same_sequence(const LogSettings& a, const LogSettings& b);

// Degrees: heading clockwise from north, pitch with the bow up, roll with starboard down.
struct LogAttitude {
  double heading_deg = 0, pitch_deg = 0, roll_deg = 0;
};

struct LogFrame {
  std::uint64_t offset = 0;  // of the frame in the log
  std::uint64_t serial = 0;  // of the instrument; 0: not in the log
  std::int64_t time_us = 0;  // of the instrument's or the recorder's clock
  LogSettings settings;
  std::optional<LogAttitude> attitude;
  std::optional<double> depth_m;
  std::optional<Pose> sonar_in_world;  // instead of attitude and depth
  std::string counts;                  // little-endian, [samples x beams]; empty: not asked for
  std::vector<float> row_gain;         // [samples], with counts and settings.row_gains
};

enum class LogFormat { aris, oculus, mcap, images, neusis };
constexpr const char* log_format_name(LogFormat format) {
  constexpr const char* kNames[] = {"aris", "oculus", "mcap", "images", "neusis"};
  return kNames[static_cast<int>(format)];
}

struct LogFrames {
  std::function<bool(std::uint64_t frame)> wants_counts;  // by number of the frame, from 0
  std::function<Status(std::uint64_t frame, const LogFrame&)> use;  // in order
};

struct LogEnd {
  std::uint64_t frames = 0;
  std::string warning;  // that the last frame is cut off; empty: none
};

struct LogChoices {
  // Of MCAP.
  std::string topic = {};  // of the images; empty: the first one
  // As in LogSettings; absent: as SonarInfo says, or else amplitudes.
  std::optional<std::array<double, 2>> db = {};
  // Of sets of neusis, which have none.
  std::optional<double> frequency_hz = {};
};

struct Log {
  LogFormat format = LogFormat::aris;
  std::string name;                                      // of the file or folder
  std::function<Result<LogEnd>(const LogFrames&)> read;  // any number of times
  std::function<Result<std::string>()> sha256;           // of the file; of a folder, see images.h
};

// "NAME: byte OFFSET: WHAT".
Error log_error(const LogBytes& log, std::uint64_t offset, const std::string& what);

// The scale of counts of 16 bits that are made of levels in floats. Its steps of 0.005 dB are finer
// than those of levels in a data set.
inline constexpr std::array<double, 2> kFloatLevelsDb = {-100, 227.675};

// Largest number of beams and samples of a frame, far above those of any instrument.
inline constexpr std::uint64_t kMostLogBeams = 4096, kMostLogSamples = 65'536;

}  // namespace ensonify
