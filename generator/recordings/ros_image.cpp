#include "recordings/ros_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/ping.h"
#include "formats/bytes.h"

namespace ensonify {
namespace {

enum Type : std::uint32_t { kUint8 = 0, kUint16 = 2, kFloat32 = 8 };

constexpr double kMostCount = 65535;

struct Members {
  std::int64_t time_us = 0;
  float frequency_hz = 0, sound_speed_m_s = 0;
  std::vector<double> azimuth_rad;  // of each beam, to port
  std::vector<double> ranges_m;     // of each sample
  bool big_endian = false;
  std::uint32_t type = 0, beams = 0;
  std::string_view data;
  std::string fault;  // what cannot be; empty: nothing
};

void take_head(Cursor& cursor, Members& image) {
  const std::int64_t seconds = cursor.number<std::int32_t>();
  image.time_us = seconds * 1'000'000 + cursor.number<std::uint32_t>() / 1000;
  cursor.text();  // frame
  image.frequency_hz = cursor.number<float>();
  image.sound_speed_m_s = cursor.number<float>();
  cursor.array<float>();  // beam widths
  cursor.array<float>();
  // Drivers leave it out.
  const bool plausible = image.sound_speed_m_s >= 1000 && image.sound_speed_m_s <= 2000;
  if (!plausible) image.sound_speed_m_s = 1500;
}

// None, with a fault, if there are more than `most`: they are expanded to eight bytes each.
std::vector<double> take_floats(Cursor& cursor, std::uint64_t most, const char* what,
                                Members& image) {
  const std::string_view raw = cursor.array<float>();
  if (raw.size() / sizeof(float) > most) {
    image.fault = fmt::format("{} {}; expected at most {}", raw.size() / sizeof(float), what, most);
    return {};
  }
  std::vector<double> values;
  for (const float value : values_in<float>(raw)) values.push_back(double{value});
  return values;
}

// Directions in a frame with z ahead, x up and y to starboard, and ranges.
void take_projected_axes(Cursor& cursor, Members& image) {
  const std::uint64_t beams = cursor.number<std::uint32_t>();
  if (beams > kMostLogBeams) {
    image.fault = fmt::format("{} beams; expected at most {}", beams, kMostLogBeams);
    return;
  }
  for (std::uint64_t i = 0; i < beams; ++i) {
    cursor.number<double>();
    const double y = cursor.number<double>(), z = cursor.number<double>();
    image.azimuth_rad.push_back(std::atan2(-y, z));
  }
  image.ranges_m = take_floats(cursor, kMostLogSamples, "ranges", image);
}

// Receive angles in the same frame, positive to starboard, and range (sample0 + n) c / (2 rate).
void take_raw_axes(Cursor& cursor, Members& image) {
  const auto rate_hz = double{cursor.number<float>()};
  const std::uint64_t samples = cursor.number<std::uint32_t>();
  const double first = cursor.number<std::uint32_t>();
  cursor.array<float>();  // delays of sectors
  cursor.array<float>();  // transmit angles
  image.azimuth_rad = take_floats(cursor, kMostLogBeams, "receive angles", image);
  if (!image.fault.empty()) return;
  for (double& azimuth_rad : image.azimuth_rad) azimuth_rad = -azimuth_rad;
  if (samples > kMostLogSamples || !(rate_hz > 0 && rate_hz < 1e9)) {
    image.fault = fmt::format("{} samples at {} Hz; expected at most {}, at a positive rate",
                              samples, rate_hz, kMostLogSamples);
    return;
  }
  for (std::uint64_t n = 0; n < samples; ++n) {
    const double sample = first + static_cast<double>(n);
    image.ranges_m.push_back(sample * double{image.sound_speed_m_s} / (2 * rate_hz));
  }
}

Members members_of(RosImageKind kind, std::string_view cdr) {
  Cursor cursor(cdr, true);
  Members image;
  take_head(cursor, image);
  if (kind == RosImageKind::projected) take_projected_axes(cursor, image);
  if (kind == RosImageKind::raw) take_raw_axes(cursor, image);
  image.big_endian = cursor.number<std::uint8_t>() != 0;
  image.type = cursor.number<std::uint32_t>();
  image.beams = cursor.number<std::uint32_t>();
  image.data = cursor.array<std::uint8_t>();
  if (image.fault.empty() && !cursor.whole()) {
    image.fault = "an image that is shorter than its members";
  }
  return image;
}

std::size_t value_bytes(const Members& image) {
  return image.type == kUint8 ? 1 : image.type == kUint16 ? 2 : sizeof(float);
}

// What is wrong with the numbers; empty: nothing. Fills axes and numbers of the settings.
std::string take_settings(const Members& image, LogSettings& settings) {
  const std::size_t beams = image.azimuth_rad.size(), samples = image.ranges_m.size();
  if (image.type != kUint8 && image.type != kUint16 && image.type != kFloat32) {
    return fmt::format("data type {}; expected 0 (UINT8), 2 (UINT16) or 8 (FLOAT32)", image.type);
  }
  settings.bits = image.type == kUint8 ? 8 : 16;
  const bool fits = beams <= kMostLogBeams && samples <= kMostLogSamples;
  if (!fits || beams < 2 || samples < 2 || image.beams != beams) {
    return fmt::format(
        "{} directions, {} ranges and a beam count of {}; expected one direction per beam, 2 to {} "
        "beams and 2 to {} ranges",
        beams, samples, image.beams, kMostLogBeams, kMostLogSamples);
  }
  if (image.data.size() != beams * samples * value_bytes(image)) {
    return fmt::format("{} bytes of data; {} ranges of {} beams take {}", image.data.size(),
                       samples, beams, beams * samples * value_bytes(image));
  }
  settings.beams = static_cast<int>(beams);
  settings.samples = static_cast<int>(samples);
  settings.frequency_hz = double{image.frequency_hz};
  if (!(settings.frequency_hz > 0 && settings.frequency_hz < 1e9)) {
    return fmt::format("a frequency of {} Hz", settings.frequency_hz);
  }
  settings.sound_speed_m_s = double{image.sound_speed_m_s};
  const double first = image.ranges_m.front(), last = image.ranges_m.back();
  const double step = (last - first) / static_cast<double>(samples - 1);
  if (!(first >= 0 && first < 1e5 && step > 0 && step < 1000 && first / step < 1e6)) {
    return fmt::format("ranges from {} to {} m", first, last);
  }
  for (std::size_t i = 0; i < samples; ++i) {
    const double even = first + static_cast<double>(i) * step;
    if (!(std::abs(image.ranges_m[i] - even) <= step / 4)) {
      return "ranges that are not equally spaced, as data sets need them";
    }
  }
  settings.first_range_m = first;
  settings.range_step_m = step;
  return {};
}

std::string take_azimuths(const Members& image, LogSettings& settings) {
  auto& azimuths = settings.azimuth_rad;
  for (const double azimuth : image.azimuth_rad) {
    if (!(std::abs(azimuth) <= std::numbers::pi)) return "a direction that is not a number";
    azimuths.push_back(azimuth);
  }
  for (std::size_t i = 1; i < azimuths.size(); ++i) {
    const bool rising = azimuths[0] < azimuths[1];
    if ((azimuths[i - 1] < azimuths[i]) == rising && azimuths[i - 1] != azimuths[i]) continue;
    return fmt::format("directions of beams {} and {} that do not rise or fall in azimuth", i - 1,
                       i);
  }
  return {};
}

// The values as they are in the message, in the order of beams and bytes of a data set.
std::string ordered_values(const Members& image, const LogSettings& settings, bool reversed) {
  const auto beams = static_cast<std::size_t>(settings.beams);
  const std::size_t width = value_bytes(image);
  std::string counts(image.data.size(), '\0');
  for (std::size_t i = 0; i < image.data.size() / width; ++i) {
    const std::size_t beam = i % beams;
    const std::size_t from = i - beam + (reversed ? beams - 1 - beam : beam);
    for (std::size_t byte = 0; byte < width; ++byte) {
      counts[i * width + (image.big_endian ? width - 1 - byte : byte)] =
          image.data[from * width + byte];
    }
  }
  return counts;
}

// Sets the scale of counts of 8 or 16 bits. Returns what is wrong; empty: nothing.
std::string take_scale(const RosValues& values, LogSettings& settings) {
  settings.db = values.db;
  if (!values.info || values.info->kind == RosScale::Kind::unknown) return "";
  const RosScale& info = *values.info;
  const std::string topic = "SonarInfo of " + values.topic;
  if (info.kind == RosScale::Kind::linear) {
    if (values.db) {
      return topic + " says that the counts are linear; expected no --db, or another --topic";
    }
    if (info.offset != 0) {
      return fmt::format(
          "{} says that a count of 0 is {:g}; expected 0, from which amplitudes "
          "begin, or --db LOW:HIGH for levels",
          topic, info.offset);
    }
    settings.gamma = info.power ? 2 : 1;
    return "";
  }
  if (!(info.scale > 0)) {
    return values.db ? ""
                     : topic +
                           " says that the counts are in dB, but not between which levels; "
                           "expected --db LOW:HIGH, or the --topic of levels";
  }
  // The limits are made of floats.
  const auto rounded = [](double level_db) { return std::round(1e4 * level_db) / 1e4; };
  const double counts = std::ldexp(1.0, settings.bits) - 1;
  const std::array<double, 2> told = {rounded(info.offset),
                                      rounded(info.offset + info.scale * counts)};
  for (int i = 0; values.db && i < 2; ++i) {
    if (std::abs((*values.db)[i] - told[i]) <= info.scale / 2) continue;
    return fmt::format("{} says {:g} to {:g} dB, but --db {:g}:{:g}; expected no --db", topic,
                       told[0], told[1], (*values.db)[0], (*values.db)[1]);
  }
  settings.db = told;
  return "";
}

// Sets the scale of counts made from floats. Returns what is wrong; empty: nothing.
std::string take_float_scale(const RosValues& values, LogSettings& settings) {
  if (values.db) {
    return "the values of " + values.topic +
           " are floats, and --db is the scale of counts; expected no --db, or the --topic of 8- "
           "or 16-bit images";
  }
  if (!values.info || values.info->kind == RosScale::Kind::unknown || !(values.info->scale > 0)) {
    return fmt::format(
        "the values of {0} are floats, and no message of {0}/info "
        "(marine_interfaces/msg/SonarInfo) before them says what they mean; "
        "expected its scale, or the --topic of 8- or 16-bit images",
        values.topic);
  }
  settings.db = kFloatLevelsDb;
  return "";
}

double level_of(double value, const RosScale& scale) {
  const double physical = scale.scale * value + scale.offset;
  if (scale.kind == RosScale::Kind::db) return physical;
  const double level_db = (scale.power ? 10 : 20) * std::log10(physical);
  return physical > 0 ? level_db : double{kNoEnergyDb};
}

// Counts of 16 bits. Returns what is wrong; empty: nothing.
std::string count_levels(const RosScale& scale, std::string& bytes) {
  const std::vector<float> values = values_in<float>(bytes);
  const auto [low, high] = kFloatLevelsDb;
  bytes.clear();
  for (const float value : values) {
    double level_db = level_of(double{value}, scale);
    if (std::isnan(level_db) || level_db > high) {
      return fmt::format("a level of {} dB; expected at most {}", level_db, high);
    }
    level_db = std::max(level_db, double{kNoEnergyDb});
    const double count = std::round((level_db - low) / (high - low) * kMostCount);
    put_value(bytes, static_cast<std::uint16_t>(count));
  }
  return "";
}

constexpr std::size_t kCdrHeader = 4;

bool is_cdr(std::string_view message) {
  return message.size() >= kCdrHeader && message.substr(0, 2) == std::string_view("\0\1", 2);
}

constexpr char kNotCdr[] = "a message that is not CDR, little-endian (00 01)";

}  // namespace

Result<RosScale> parse_sonar_info(const LogBytes& log, std::uint64_t offset,
                                  std::string_view message) {
  if (!is_cdr(message)) return log_error(log, offset, kNotCdr);
  Cursor cursor(message.substr(kCdrHeader), true);
  cursor.number<std::int32_t>();  // time
  cursor.number<std::uint32_t>();
  cursor.text();                  // frame
  cursor.text();                  // model
  cursor.text();                  // calibration
  cursor.number<std::int32_t>();  // ... its time
  cursor.number<std::uint32_t>();
  cursor.array<float>();  // pulse lengths
  cursor.array<float>();  // bandwidths
  cursor.array<std::uint8_t>();
  const auto quantity = cursor.number<std::uint8_t>();
  const auto kind = cursor.number<std::uint8_t>();
  cursor.number<std::uint8_t>();  // reference
  RosScale scale;
  scale.scale = double{cursor.number<float>()};
  scale.offset = double{cursor.number<float>()};
  if (!cursor.whole())
    return log_error(log, offset, "a SonarInfo that is shorter than its members");
  if (!std::isfinite(scale.scale) || !std::isfinite(scale.offset)) {
    return log_error(log, offset, "a SonarInfo whose scale or offset is not a finite number");
  }
  constexpr std::uint8_t kPower = 3, kLinear = 1, kDb = 2;
  scale.power = quantity == kPower;
  if (kind == kLinear) scale.kind = RosScale::Kind::linear;
  if (kind == kDb) scale.kind = RosScale::Kind::db;
  return scale;
}

Result<LogFrame> parse_ros_image(const LogBytes& log, std::uint64_t offset, RosImageKind kind,
                                 std::string_view message, const RosValues& values,
                                 bool with_counts) {
  if (!is_cdr(message)) return log_error(log, offset, kNotCdr);
  const Members image = members_of(kind, message.substr(kCdrHeader));
  if (!image.fault.empty()) return log_error(log, offset, image.fault);
  LogFrame frame;
  frame.offset = offset;
  frame.time_us = image.time_us;
  LogSettings& settings = frame.settings;
  std::string fault = take_settings(image, settings);
  if (fault.empty()) fault = take_azimuths(image, settings);
  const bool is_float = image.type == kFloat32;
  if (fault.empty()) {
    fault = is_float ? take_float_scale(values, settings) : take_scale(values, settings);
  }
  if (!fault.empty()) return log_error(log, offset, fault);
  auto& azimuths = settings.azimuth_rad;
  const bool reversed = azimuths[0] > azimuths[1];
  if (reversed) std::reverse(azimuths.begin(), azimuths.end());
  if (!with_counts) return frame;
  frame.counts = ordered_values(image, settings, reversed);
  if (is_float) fault = count_levels(*values.info, frame.counts);
  if (!fault.empty()) return log_error(log, offset, fault);
  return frame;
}

}  // namespace ensonify
