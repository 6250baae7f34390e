#include "recordings/oculus.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/units.h"
#include "formats/bytes.h"
#include "formats/deflate.h"

namespace ensonify {

using namespace oculus;

namespace {

constexpr std::uint64_t kMostHeader = 4096;  // of a file or item; longer ones have unknown members
constexpr std::uint64_t kMostMessage = std::uint64_t{1} << 28;
// Deflate makes at most 1032 bytes of one.
constexpr std::uint64_t kMostInflation = 1032;

bool is_speed(double value) { return value >= 1000 && value <= 2000; }

// 0 and 255 mean 1, 127 means one half.
double gamma_of(std::uint8_t value) { return value == 0 ? 1.0 : value / 255.0; }

std::optional<LogAttitude> attitude_at(std::string_view message, std::size_t at) {
  const LogAttitude attitude{value_at<double>(message, at), value_at<double>(message, at + 8),
                             value_at<double>(message, at + 16)};
  const bool finite = std::isfinite(attitude.heading_deg) && std::isfinite(attitude.pitch_deg) &&
                      std::isfinite(attitude.roll_deg);
  const bool known = attitude.heading_deg != 0 || attitude.pitch_deg != 0 || attitude.roll_deg != 0;
  return finite && known ? std::optional(attitude) : std::nullopt;
}

// Reads the numbers and checks each by itself.
Result<OculusPing> numbers_of(const LogBytes& log, std::uint64_t offset, std::string_view message,
                              const PingLayout& at) {
  const auto wrong = [&](std::size_t place, const std::string& what) {
    return log_error(log, offset + place, what);
  };
  OculusPing ping;
  ping.mode = value_at<std::uint8_t>(message, kMode);
  ping.gamma = gamma_of(value_at<std::uint8_t>(message, kGamma));
  ping.frequency_hz = value_at<double>(message, at.frequency);
  ping.sound_speed_m_s = value_at<double>(message, at.sound_speed);
  ping.range_step_m = value_at<double>(message, at.range_step);
  ping.samples = value_at<std::uint16_t>(message, at.samples);
  ping.beams = value_at<std::uint16_t>(message, at.beams);
  ping.image_offset = value_at<std::uint32_t>(message, at.image_offset);
  const auto size = value_at<std::uint8_t>(message, at.data_size);
  if (size != 0 && size != 1 && size != 3) {
    return wrong(at.data_size, fmt::format("data size {}; expected 0 (8 bits), 1 (16 bits) or 3 "
                                           "(32 bits)",
                                           size));
  }
  ping.bytes_per_count = size + 1;
  if (!(ping.frequency_hz > 0 && ping.frequency_hz < 1e9)) {
    return wrong(at.frequency, fmt::format("a frequency of {} Hz", ping.frequency_hz));
  }
  if (!is_speed(ping.sound_speed_m_s)) {
    ping.sound_speed_m_s = value_at<double>(message, kDemandedSpeed);
  }
  if (!is_speed(ping.sound_speed_m_s)) {
    return wrong(at.sound_speed, "no sound speed; expected 1000 to 2000 m/s");
  }
  if (!(ping.range_step_m > 0 && ping.range_step_m < 1000)) {
    return wrong(at.range_step, fmt::format("a range resolution of {} m", ping.range_step_m));
  }
  if (ping.samples < 2 || ping.beams < 2 || std::cmp_greater(ping.beams, kMostLogBeams)) {
    return wrong(at.samples, fmt::format("{} ranges and {} beams; expected at least 2 of each, and "
                                         "at most {} beams",
                                         ping.samples, ping.beams, kMostLogBeams));
  }
  return ping;
}

// Whether rows begin with a gain follows from the size of the image: the flag of version 2 is not
// reliable.
Status take_image(const LogBytes& log, std::uint64_t offset, std::string_view message,
                  const PingLayout& at, OculusPing& ping) {
  const std::uint64_t image = value_at<std::uint32_t>(message, at.image_size);
  const auto rows = static_cast<std::uint64_t>(ping.samples);
  const std::uint64_t plain = rows * static_cast<std::uint64_t>(ping.beams) *
                              static_cast<std::uint64_t>(ping.bytes_per_count);
  ping.row_gains = image == plain + 4 * rows;
  if (image != plain && !ping.row_gains) {
    return log_error(log, offset + at.image_size,
                     fmt::format("an image of {} bytes; {} ranges of {} beams take {} bytes, or {} "
                                 "with gains",
                                 image, rows, ping.beams, plain, plain + 4 * rows));
  }
  const std::uint64_t bearings = at.end + 2 * static_cast<std::uint64_t>(ping.beams);
  if (message.size() < bearings || ping.image_offset < bearings ||
      ping.image_offset > message.size() || message.size() - ping.image_offset < image) {
    return log_error(log, offset + at.image_offset,
                     fmt::format("an image at byte {} of the message, whose bearings end at {} and "
                                 "which has {} bytes",
                                 ping.image_offset, bearings, message.size()));
  }
  return {};
}

Status take_bearings(const LogBytes& log, std::uint64_t offset, std::string_view message,
                     const PingLayout& at, OculusPing& ping) {
  const auto count = static_cast<std::size_t>(ping.beams);
  ping.bearing_cdeg = values_in<std::int16_t>(message.substr(at.end, 2 * count));
  const auto& bearings = ping.bearing_cdeg;
  const bool rising = bearings[0] < bearings[1];
  for (std::size_t i = 1; i < count; ++i) {
    if (bearings[i] != bearings[i - 1] && (bearings[i - 1] < bearings[i]) == rising) continue;
    return log_error(log, offset + at.end + 2 * i,
                     fmt::format("bearing {} of beam {} follows {}; expected bearings that rise or "
                                 "fall throughout",
                                 bearings[i] / 100.0, i, bearings[i - 1] / 100.0));
  }
  return {};
}

LogSettings settings_of(const OculusPing& ping) {
  LogSettings settings;
  settings.instrument = "Oculus";
  settings.mode = ping.mode;
  settings.beams = ping.beams;
  settings.samples = ping.samples;
  settings.bits = 8 * ping.bytes_per_count;
  settings.row_gains = ping.row_gains;
  settings.gamma = ping.gamma;
  settings.frequency_hz = ping.frequency_hz;
  settings.sound_speed_m_s = ping.sound_speed_m_s;
  settings.range_step_m = ping.range_step_m;
  for (const std::int16_t bearing : ping.bearing_cdeg) {
    settings.azimuth_rad.push_back(radians(-bearing / 100.0));  // to port is positive
  }
  std::sort(settings.azimuth_rad.begin(), settings.azimuth_rad.end());
  return settings;
}

// Splits the rows into gains and counts with beam 0 to starboard.
void take_counts(const OculusPing& ping, std::string_view message, LogFrame& frame) {
  const auto beams = static_cast<std::size_t>(ping.beams);
  const auto width = static_cast<std::size_t>(ping.bytes_per_count);
  const bool reversed = ping.bearing_cdeg[0] < ping.bearing_cdeg[1];
  frame.counts.resize(static_cast<std::size_t>(ping.samples) * beams * width);
  const char* from = message.data() + ping.image_offset;
  char* to = frame.counts.data();
  for (int row = 0; row < ping.samples; ++row) {
    if (ping.row_gains) {
      std::uint32_t gain = 0;
      std::memcpy(&gain, from, sizeof gain);
      frame.row_gain.push_back(static_cast<float>(gain));
      from += sizeof gain;
    }
    for (std::size_t beam = 0; beam < beams; ++beam) {
      const std::size_t source = reversed ? beams - 1 - beam : beam;
      std::memcpy(to + beam * width, from + source * width, width);
    }
    from += beams * width;
    to += beams * width;
  }
}

// Hands the pings of a log on and counts them.
class PingUse {
 public:
  PingUse(const LogBytes& log, const LogFrames& frames) : log_(log), frames_(frames) {}

  // `time_s`: of the item; none: of the message.
  Status add(std::uint64_t offset, std::string_view message, std::optional<double> time_s) {
    const auto ping = parse_oculus_ping(log_, offset, message);
    if (!ping) return ping.error();
    if (!*ping) return {};
    LogFrame frame;
    frame.offset = offset;
    frame.serial = value_at<std::uint16_t>(message, 2);
    frame.time_us = std::llround(time_s.value_or(start_of(**ping)) * 1e6);
    frame.settings = settings_of(**ping);
    frame.attitude = (*ping)->attitude;
    if (frames_.wants_counts(end.frames)) take_counts(**ping, message, frame);
    const Status used = frames_.use(end.frames, frame);
    ++end.frames;
    return used;
  }

  LogEnd end;

 private:
  // The clock of version 1 has 32 bits of nanoseconds.
  double start_of(const OculusPing& ping) {
    if (ping.version != 1) return ping.start_s;
    constexpr double kTurn_s = 4294967296e-9;
    while (turns_ * kTurn_s + ping.start_s < last_s_) ++turns_;
    last_s_ = turns_ * kTurn_s + ping.start_s;
    return last_s_;
  }

  const LogBytes& log_;
  const LogFrames& frames_;
  double turns_ = 0, last_s_ = 0;
};

std::string cut_off(const LogBytes& log, std::uint64_t offset, std::uint64_t frames) {
  return fmt::format("{}: byte {}: the last message is cut off; used the {} pings before it",
                     log.name, offset, frames);
}

Result<LogEnd> read_messages(const LogBytes& log, const LogFrames& frames) {
  PingUse pings(log, frames);
  for (std::uint64_t offset = 0; offset < log.size;) {
    if (log.size - offset < kMessageHeader) {
      pings.end.warning = cut_off(log, offset, pings.end.frames);
      break;
    }
    const auto header = log.read(offset, kMessageHeader);
    if (!header) return header.error();
    if (value_at<std::uint16_t>(*header, 0) != kMessageMark) {
      return log_error(log, offset,
                       "no message begins here; expected 53 4f. Cut the file off here");
    }
    const std::uint64_t size = kMessageHeader + value_at<std::uint32_t>(*header, 10);
    if (log.size - offset < size) {
      pings.end.warning = cut_off(log, offset, pings.end.frames);
      break;
    }
    if (size > kMostMessage) {
      return log_error(log, offset + 10,
                       fmt::format("a message of {} bytes; expected at most {}. Cut the file off here",
                                   size, kMostMessage));
    }
    const auto message = log.read(offset, size);
    if (!message) return message.error();
    if (const Status used = pings.add(offset, *message, {}); !used) return used.error();
    offset += size;
  }
  return pings.end;
}

struct Item {
  std::uint16_t type = 0, compression = 0;
  double time_s = 0;
  std::uint64_t header = 0, original = 0, payload = 0;  // bytes
};

Result<Item> parse_item(const LogBytes& log, std::uint64_t offset, std::string_view bytes) {
  if (value_at<std::uint32_t>(bytes, 0) != kItemMark) {
    return log_error(log, offset,
                     "no item begins here; expected dd cc bb aa. Cut the file off here");
  }
  Item item;
  item.header = value_at<std::uint32_t>(bytes, 4);
  if (item.header < kItemHeader || item.header > kMostHeader) {
    return log_error(
        log, offset + 4,
        fmt::format("an item header of {} bytes; expected {}", item.header, kItemHeader));
  }
  item.type = value_at<std::uint16_t>(bytes, 8);
  item.time_s = value_at<double>(bytes, 16);
  item.compression = value_at<std::uint16_t>(bytes, 24);
  item.original = value_at<std::uint32_t>(bytes, 28);
  item.payload = value_at<std::uint32_t>(bytes, 32);
  return item;
}

// Uncompressed, or as qCompress of Qt: the size, big-endian, and a stream of zlib.
Result<std::string> payload_of(const LogBytes& log, std::uint64_t offset, const Item& item) {
  const auto wrong = [&](const std::string& what) { return log_error(log, offset + 24, what); };
  if (item.payload > kMostMessage) {
    return wrong(fmt::format("an item of {} bytes; expected at most {}", item.payload, kMostMessage));
  }
  auto payload = log.read(offset + item.header, item.payload);
  if (!payload || item.compression == 0) return payload;
  if (item.compression != 1) {
    return wrong(
        fmt::format("compression {}; expected 0 (none) or 1 (qCompress). Save the log "
                    "again without compression",
                    item.compression));
  }
  if (item.payload < 4 || item.original > kMostMessage ||
      item.original > kMostInflation * item.payload) {
    return wrong(fmt::format("{} compressed bytes for {}; more than zlib can hold", item.payload,
                             item.original));
  }
  auto inflated = inflate_zlib(std::string_view(*payload).substr(4), item.original);
  if (!inflated) return wrong("the compressed data are damaged");
  return std::move(*inflated);
}

Result<LogEnd> read_items(const LogBytes& log, const LogFrames& frames, std::uint64_t offset) {
  PingUse pings(log, frames);
  while (offset < log.size) {
    const std::uint64_t left = log.size - offset;
    Result<Item> item = Item{};
    if (left >= kItemHeader) {
      const auto bytes = log.read(offset, kItemHeader);
      if (!bytes) return bytes.error();
      item = parse_item(log, offset, *bytes);
      if (!item) return item.error();
    }
    if (left < kItemHeader || left < item->header + item->payload) {
      pings.end.warning = cut_off(log, offset, pings.end.frames);
      break;
    }
    if (item->type == kSonarItem) {
      if (!std::isfinite(item->time_s) || std::abs(item->time_s) > 1e11) {
        return log_error(log, offset + 16, "a time that is not a number of seconds since 1970");
      }
      const auto payload = payload_of(log, offset, *item);
      if (!payload) return payload.error();
      const Status used = pings.add(offset + item->header, *payload, item->time_s);
      if (!used) return used.error();
    }
    offset += item->header + item->payload;
  }
  return pings.end;
}

}  // namespace

bool is_oculus(std::string_view bytes) {
  return bytes.size() >= 4 && (value_at<std::uint32_t>(bytes, 0) == kFileMark ||
                               value_at<std::uint16_t>(bytes, 0) == kMessageMark);
}

Result<std::optional<OculusPing>> parse_oculus_ping(const LogBytes& log, std::uint64_t offset,
                                                    std::string_view message) {
  std::optional<OculusPing> none;
  if (message.size() < kMessageHeader || value_at<std::uint16_t>(message, 0) != kMessageMark) {
    return log_error(log, offset, "not a message of an Oculus sonar; expected 53 4f");
  }
  if (value_at<std::uint16_t>(message, 6) != kSimplePing) return none;
  const int version = value_at<std::uint16_t>(message, 8) == 2 ? 2 : 1;
  const PingLayout& at = version == 2 ? kVersion2 : kVersion1;
  if (message.size() < at.end) {
    return log_error(
        log, offset,
        fmt::format("a ping of {} bytes; its numbers alone take {}", message.size(), at.end));
  }
  auto ping = numbers_of(log, offset, message, at);
  if (!ping) return ping.error();
  ping->version = version;
  if (version == 2) {
    ping->attitude = attitude_at(message, at.attitude);
    ping->start_s = value_at<double>(message, at.start);
    if (!(std::abs(ping->start_s) < 1e11)) ping->start_s = 0;
  } else {
    ping->start_s = value_at<std::uint32_t>(message, at.start) * 1e-9;
  }
  if (const Status image = take_image(log, offset, message, at, *ping); !image) {
    return image.error();
  }
  if (const Status taken = take_bearings(log, offset, message, at, *ping); !taken) {
    return taken.error();
  }
  return std::optional(std::move(*ping));
}

Result<LogEnd> read_oculus(const LogBytes& log, const LogFrames& frames) {
  const auto mark = log.read(0, sizeof kFileMark);
  if (!mark) return mark.error();
  if (value_at<std::uint32_t>(*mark, 0) != kFileMark) return read_messages(log, frames);
  if (log.size < kFileHeader) return log_error(log, log.size, "the header of the log ends here");
  const auto header = log.read(0, kFileHeader);
  if (!header) return header.error();
  const std::uint64_t size = value_at<std::uint32_t>(*header, 4);
  if (size < kFileHeader || size > kMostHeader) {
    return log_error(log, 4, fmt::format("a header of {} bytes; expected {}", size, kFileHeader));
  }
  if (value_at<std::uint16_t>(*header, 26) != 0) {
    return log_error(log, 26, "the log is encrypted; save it again without encryption");
  }
  return read_items(log, frames, size);
}

}  // namespace ensonify
