#include <algorithm>
#include <cmath>

#include "formats/bytes.h"
#include "recordings/oculus.h"

namespace ensonify {

using namespace oculus;

namespace {

// The numbers of a message of version 2; the flags ask for meters, and for 16 bits and gains where
// there are any.
std::string ping_numbers(const OculusPing& ping, std::uint32_t number, std::uint64_t image_size) {
  const PingLayout& at = kVersion2;
  std::string bytes(at.end, '\0');
  put_value_at(bytes, 0, kMessageMark);
  put_value_at(bytes, 6, kSimplePing);
  put_value_at(bytes, 8, std::uint16_t{2});
  put_value_at(bytes, 10,
               static_cast<std::uint32_t>(ping.image_offset + image_size - kMessageHeader));
  put_value_at(bytes, kMode, ping.mode);
  put_value_at(bytes, kGamma, static_cast<std::uint8_t>(std::lround(255 * ping.gamma)));
  const int flags = 1 | (ping.bytes_per_count > 1 ? 2 : 0) | (ping.row_gains ? 4 : 0) | 8;
  put_value_at(bytes, kFlags, static_cast<std::uint8_t>(flags));
  put_value_at(bytes, kRange, ping.samples * ping.range_step_m);
  put_value_at(bytes, kDemandedSpeed, ping.sound_speed_m_s);
  put_value_at(bytes, kPingId, number);
  put_value_at(bytes, at.frequency, ping.frequency_hz);
  if (ping.attitude) {
    put_value_at(bytes, at.attitude, ping.attitude->heading_deg);
    put_value_at(bytes, at.attitude + 8, ping.attitude->pitch_deg);
    put_value_at(bytes, at.attitude + 16, ping.attitude->roll_deg);
  }
  put_value_at(bytes, at.sound_speed, ping.sound_speed_m_s);
  put_value_at(bytes, at.start, ping.start_s);
  put_value_at(bytes, at.data_size, static_cast<std::uint8_t>(ping.bytes_per_count - 1));
  put_value_at(bytes, at.range_step, ping.range_step_m);
  put_value_at(bytes, at.samples, static_cast<std::uint16_t>(ping.samples));
  put_value_at(bytes, at.beams, static_cast<std::uint16_t>(ping.beams));
  put_value_at(bytes, at.image_offset, static_cast<std::uint32_t>(ping.image_offset));
  put_value_at(bytes, at.image_size, static_cast<std::uint32_t>(image_size));
  put_value_at(bytes, at.message_size, static_cast<std::uint32_t>(ping.image_offset + image_size));
  return bytes;
}

}  // namespace

std::string oculus_file_header(double time_s) {
  std::string bytes(kFileHeader, '\0');
  put_value_at(bytes, 0, kFileMark);
  put_value_at(bytes, 4, static_cast<std::uint32_t>(kFileHeader));
  bytes.replace(8, 6, "Oculus");
  put_value_at(bytes, 24, std::uint16_t{1});
  put_value_at(bytes, 40, time_s);
  return bytes;
}

std::string oculus_ping_item(const OculusPing& ping, std::uint32_t number, double time_s,
                             std::string_view counts, const std::vector<float>& row_gain) {
  OculusPing placed = ping;
  placed.image_offset = kVersion2.end + 2 * ping.bearing_cdeg.size();
  placed.row_gains = !row_gain.empty();
  std::string message =
      ping_numbers(placed, number, counts.size() + sizeof(std::uint32_t) * row_gain.size());
  for (const std::int16_t bearing : ping.bearing_cdeg) put_value(message, bearing);
  const std::size_t row_bytes = counts.size() / static_cast<std::size_t>(ping.samples);
  for (std::size_t row = 0; row < static_cast<std::size_t>(ping.samples); ++row) {
    if (!row_gain.empty()) {
      constexpr float kMostGain = 4294967040;  // the largest float below 2^32
      put_value(message, static_cast<std::uint32_t>(std::clamp(row_gain[row], 0.0f, kMostGain)));
    }
    message += counts.substr(row * row_bytes, row_bytes);
  }
  std::string item(kItemHeader, '\0');
  put_value_at(item, 0, kItemMark);
  put_value_at(item, 4, static_cast<std::uint32_t>(kItemHeader));
  put_value_at(item, 8, kSonarItem);
  put_value_at(item, 16, time_s);
  put_value_at(item, 28, static_cast<std::uint32_t>(message.size()));
  put_value_at(item, 32, static_cast<std::uint32_t>(message.size()));
  return item + message;
}

}  // namespace ensonify
