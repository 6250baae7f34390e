// Numbers and offsets of Oculus logs, for reading and writing. Private to recordings/.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ensonify::oculus {

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

}  // namespace ensonify::oculus
