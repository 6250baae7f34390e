// Logs of Blueprint Subsea's Oculus sonars: the .oculus files of its viewer, a header and items of
// which some hold a message of the sonar, and plain streams of these messages. Little-endian,
// messages without padding.
//
// A ping is a "simple ping result" of version 1 or 2: its numbers, the bearings of its beams in
// hundredths of a degree, clockwise, and rows of counts of 8, 16 or 32 bits, nearest first. Where
// gains are sent, each row begins with one of 4 bytes.
//
// Layout: the drivers oculus_driver (ENSTA Bretagne, commit ad3a7d7) and liboculus (University of
// Washington, BSD, commit f338306), in which the same numbers stand.
//
//   is_oculus                          by the first bytes
//   OculusPing  parse_oculus_ping      one message
//   read_oculus                        ping by ping
//   oculus_file_header  oculus_ping_item   for writers, with pings of version 2
//   oculus::PingLayout                 numbers and offsets, private to recordings/
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recordings/log.h"

namespace ensonify {

bool is_oculus(std::string_view bytes);

struct OculusPing {
  int version = 2;        // of the message
  std::uint8_t mode = 0;  // master mode: 1 low, 2 high frequency
  double gamma = 1;
  double frequency_hz = 0, sound_speed_m_s = 0;
  std::optional<LogAttitude> attitude;  // of version 2
  double start_s = 0;                   // since the sonar was switched on; see read_oculus
  int bytes_per_count = 1;
  double range_step_m = 0;
  int samples = 0, beams = 0;
  bool row_gains = false;
  std::uint64_t image_offset = 0;          // in the message
  std::vector<std::int16_t> bearing_cdeg;  // [beams], in the order of the message
};

// `message`: a whole message with its header; `offset`: its place in the log. None: not a simple
// ping result. Error (usage): sizes that do not fit, or numbers that no ping can have.
Result<std::optional<OculusPing>> parse_oculus_ping(const LogBytes& log, std::uint64_t offset,
                                                    std::string_view message);

// Times: of the log's items; in a stream, `start_s` of version 2, and the nanoseconds modulo 2^32
// of version 1.
Result<LogEnd> read_oculus(const LogBytes& log, const LogFrames& frames);

// The header of a file that was begun at this time (seconds since 1970).
std::string oculus_file_header(double time_s);

// An item with a ping. `ping.bearing_cdeg` and `counts` ([samples x beams]) are in the order of the
// message; `row_gain`: [samples], or empty.
std::string oculus_ping_item(const OculusPing& ping, std::uint32_t number, double time_s,
                             std::string_view counts, const std::vector<float>& row_gain);

namespace oculus {

inline constexpr std::uint32_t kFileMark = 0x11223344, kItemMark = 0xaabbccdd;
inline constexpr std::uint16_t kMessageMark = 0x4f53;
inline constexpr std::uint64_t kFileHeader = 48, kItemHeader = 40, kMessageHeader = 16;
inline constexpr std::uint16_t kSonarItem = 10, kSimplePing = 0x23;

// Offsets in a message, which differ between the versions behind the fire message.
struct PingLayout {
  std::size_t frequency, attitude, sound_speed, start, data_size, range_step, samples, beams,
      image_offset, image_size, message_size, end;
};
inline constexpr PingLayout kVersion1 = {61, 0, 85, 93, 97, 98, 106, 108, 110, 114, 118, 122};
inline constexpr PingLayout kVersion2 = {97, 121, 145, 153, 161, 162, 170, 172, 190, 194, 198, 202};
inline constexpr std::size_t kMode = 16, kGamma = 19, kFlags = 20, kRange = 21, kDemandedSpeed = 37;
inline constexpr std::size_t kPingId = 89;  // of version 2

}  // namespace oculus
}  // namespace ensonify
