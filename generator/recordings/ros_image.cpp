#include "recordings/ros_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/bytes.h"

namespace ensonify {
namespace {

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

// What is wrong with the numbers; empty: nothing. Fills axes and numbers of the settings.
std::string take_settings(const Members& image, LogSettings& settings) {
  const std::size_t beams = image.azimuth_rad.size(), samples = image.ranges_m.size();
  if (image.type != 0 && image.type != 2) {
    return fmt::format("data type {}; expected 0 (UINT8) or 2 (UINT16)", image.type);
  }
  settings.bits = image.type == 0 ? 8 : 16;
  const bool fits = beams <= kMostLogBeams && samples <= kMostLogSamples;
  if (!fits || beams < 2 || samples < 2 || image.beams != beams) {
    return fmt::format(
        "{} directions, {} ranges and a beam count of {}; expected one direction per beam, 2 to {} "
        "beams and 2 to {} ranges",
        beams, samples, image.beams, kMostLogBeams, kMostLogSamples);
  }
  if (image.data.size() != beams * samples * static_cast<std::size_t>(settings.bits / 8)) {
    return fmt::format("{} bytes of data; {} ranges of {} beams take {}", image.data.size(),
                       samples, beams,
                       beams * samples * static_cast<std::size_t>(settings.bits / 8));
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

std::string counts_of(const Members& image, const LogSettings& settings, bool reversed) {
  const auto beams = static_cast<std::size_t>(settings.beams);
  const auto width = static_cast<std::size_t>(settings.bits / 8);
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

}  // namespace

Result<LogFrame> parse_ros_image(const LogBytes& log, std::uint64_t offset, RosImageKind kind,
                                 std::string_view message, bool with_counts) {
  constexpr std::size_t kHeader = 4;
  if (message.size() < kHeader || message.substr(0, 2) != std::string_view("\0\1", 2)) {
    return log_error(log, offset, "a message that is not CDR, little-endian (00 01)");
  }
  const Members image = members_of(kind, message.substr(kHeader));
  if (!image.fault.empty()) return log_error(log, offset, image.fault);
  LogFrame frame;
  frame.offset = offset;
  frame.time_us = image.time_us;
  LogSettings& settings = frame.settings;
  std::string fault = take_settings(image, settings);
  if (fault.empty()) fault = take_azimuths(image, settings);
  if (!fault.empty()) return log_error(log, offset, fault);
  auto& azimuths = settings.azimuth_rad;
  const bool reversed = azimuths[0] > azimuths[1];
  if (reversed) std::reverse(azimuths.begin(), azimuths.end());
  if (with_counts) frame.counts = counts_of(image, settings, reversed);
  return frame;
}

}  // namespace ensonify
