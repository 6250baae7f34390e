#include "recordings/aris.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "formats/bytes.h"
#include "recordings/aris_beams.h"

namespace ensonify {
namespace {

constexpr std::uint32_t kSignature = 0x05464444, kDidson3 = 0x03464444, kDidson4 = 0x04464444;

// Offsets in a frame header.
enum Member : std::size_t {
  kFrameIndex = 0,
  kFrameTime = 4,
  kVersion = 12,
  kSonarTime = 20,
  kWindowStart = 52,
  kWindowLength = 56,
  kDepth = 128,
  kPitch = 136,
  kRoll = 144,
  kHeading = 152,
  kCompassHeading = 160,
  kCompassPitch = 164,
  kCompassRoll = 168,
  kSampleRate = 420,
  kPingMode = 436,
  kFrequencyHigh = 440,
  kSamplePeriod = 452,
  kSoundSpeed = 464,
  kSamples = 468,
  kSampleStart = 476,
  kLargeLens = 480,
  kSystem = 484,
  kSerial = 488,
  kReordered = 516,
};

// Offsets in the file header.
enum FileMember : std::size_t {
  kFrameCount = 4,
  kHighResolution = 12,
  kRawBeams = 16,
  kSamplesPerChannel = 24,
  kFileSerial = 44,
  kFileLargeLens = 452,
};

// The platform's attitude or, where it is not recorded, that of the compass.
void take_attitude(std::string_view bytes, ArisHead& head) {
  head.heading_deg = value_at<float>(bytes, kHeading);
  head.pitch_deg = value_at<float>(bytes, kPitch);
  head.roll_deg = value_at<float>(bytes, kRoll);
  if (head.heading_deg == 0 && head.pitch_deg == 0 && head.roll_deg == 0) {
    head.heading_deg = value_at<float>(bytes, kCompassHeading);
    head.pitch_deg = value_at<float>(bytes, kCompassPitch);
    head.roll_deg = value_at<float>(bytes, kCompassRoll);
  }
}

const char* system_name(std::uint32_t system) {
  return system == kAris3000 ? "ARIS 3000" : system == kAris1200 ? "ARIS 1200" : "ARIS 1800";
}

LogSettings settings_of(const ArisHead& head, std::span<const double> azimuths_deg) {
  LogSettings settings;
  settings.instrument = system_name(head.system);
  if (head.large_lens != 0) settings.instrument += " with telephoto lens";
  settings.mode = head.ping_mode;
  settings.beams = static_cast<int>(azimuths_deg.size());
  settings.samples = static_cast<int>(head.samples);
  settings.db = {{0, kArisSpan_db}};
  settings.frequency_hz = aris_frequency_hz(head.system, head.high_frequency != 0);
  settings.sound_speed_m_s = double{head.sound_speed_m_s};
  const double metres_per_us = settings.sound_speed_m_s / 2 * 1e-6;
  settings.first_range_m = head.sample_start_us * metres_per_us;
  settings.range_step_m = head.sample_period_us * metres_per_us;
  for (const double azimuth : azimuths_deg) {
    settings.azimuth_rad.push_back(radians(azimuth));
  }
  return settings;
}

LogFrame frame_of(const ArisHead& head, std::uint64_t offset,
                  std::span<const double> azimuths_deg) {
  LogFrame frame;
  frame.offset = offset;
  frame.serial = head.serial;
  frame.time_us = head.time_us;
  frame.settings = settings_of(head, azimuths_deg);
  const bool finite = std::isfinite(head.heading_deg) && std::isfinite(head.pitch_deg) &&
                      std::isfinite(head.roll_deg);
  if (finite && (head.heading_deg != 0 || head.pitch_deg != 0 || head.roll_deg != 0)) {
    frame.attitude = {double{head.heading_deg}, double{head.pitch_deg}, double{head.roll_deg}};
  }
  if (std::isfinite(head.depth_m) && head.depth_m != 0) frame.depth_m = double{head.depth_m};
  return frame;
}

}  // namespace

bool is_aris(std::string_view bytes) {
  return bytes.size() >= 4 && value_at<std::uint32_t>(bytes, 0) == kSignature;
}

bool is_didson(std::string_view bytes) {
  const auto signature = bytes.size() >= 4 ? value_at<std::uint32_t>(bytes, 0) : 0;
  return signature == kDidson3 || signature == kDidson4;
}

int aris_beams(std::uint32_t ping_mode) {
  if (ping_mode == 0 || ping_mode > 12) return 0;
  return ping_mode <= 2 ? 48 : ping_mode <= 5 ? 96 : ping_mode <= 8 ? 64 : 128;
}

double aris_frequency_hz(std::uint32_t system, bool high) {
  if (system == kAris3000) return high ? 3.0e6 : 1.8e6;
  if (system == kAris1200) return high ? 1.2e6 : 0.7e6;
  return high ? 1.8e6 : 1.1e6;
}

std::span<const double> aris_azimuths_deg(std::uint32_t system, int beams, bool large_lens) {
  if (large_lens) {
    if (beams == 48) return kTelephoto48;
    if (beams == 96) return kTelephoto96;
  } else if (system == kAris3000) {
    if (beams == 64) return kAris3000Beams64;
    if (beams == 128) return kAris3000Beams128;
  } else {
    if (beams == 48) return kAris1800Beams48;
    if (beams == 96 && system == kAris1800) return kAris1800Beams96;
  }
  return {};
}

Result<ArisHead> parse_aris_head(const LogBytes& log, std::uint64_t offset,
                                 std::string_view bytes) {
  ENSONIFY_ASSERT(bytes.size() >= kArisHeader);
  const auto word = [&](std::size_t at) { return value_at<std::uint32_t>(bytes, at); };
  const auto wrong = [&](std::size_t at, const std::string& what) {
    return log_error(log, offset + at, what);
  };
  if (word(kVersion) != kSignature) {
    return wrong(kVersion,
                 "no frame begins here; expected 44 44 46 05. Cut the file off before "
                 "the frame, or copy it again");
  }
  ArisHead head;
  head.frame = word(kFrameIndex);
  head.time_us = value_at<std::int64_t>(bytes, kSonarTime);
  if (head.time_us == 0) head.time_us = value_at<std::int64_t>(bytes, kFrameTime);
  head.ping_mode = word(kPingMode);
  head.high_frequency = word(kFrequencyHigh);
  head.samples = word(kSamples);
  head.sample_period_us = word(kSamplePeriod);
  head.sample_start_us = word(kSampleStart);
  head.sound_speed_m_s = value_at<float>(bytes, kSoundSpeed);
  head.large_lens = word(kLargeLens);
  head.system = word(kSystem);
  head.serial = word(kSerial);
  head.reordered = word(kReordered);
  head.depth_m = value_at<float>(bytes, kDepth);
  take_attitude(bytes, head);
  if (head.time_us < 0) return wrong(kSonarTime, "a time before 1970");
  if (aris_beams(head.ping_mode) == 0) {
    return wrong(kPingMode, fmt::format("ping mode {}; expected 1 to 12", head.ping_mode));
  }
  if (head.samples < 2 || head.samples > kMostLogSamples) {
    return wrong(kSamples, fmt::format("{} samples per beam; expected 2 to {}", head.samples,
                                       kMostLogSamples));
  }
  if (head.sample_period_us == 0 || head.sample_period_us > 1'000'000) {
    return wrong(kSamplePeriod, fmt::format("a sample period of {} us; expected 1 to 1000000",
                                            head.sample_period_us));
  }
  if (head.sample_start_us > 10'000'000) {
    return wrong(kSampleStart, fmt::format("sampling starts after {} us; expected at most 10000000",
                                           head.sample_start_us));
  }
  if (!(head.sound_speed_m_s >= 1000 && head.sound_speed_m_s <= 2000)) {
    return wrong(kSoundSpeed, fmt::format("a sound speed of {} m/s; expected 1000 to 2000",
                                          head.sound_speed_m_s));
  }
  if (head.system > kAris1200) {
    return wrong(kSystem, fmt::format("system type {}; expected 0 (ARIS 1800), 1 (3000) or 2 "
                                      "(1200)",
                                      head.system));
  }
  if (head.reordered == 0) {
    return wrong(kReordered,
                 "the samples are in the order of the receiver's channels; save the "
                 "recording with ARIScope, which orders them by beam");
  }
  return head;
}

Result<LogEnd> read_aris(const LogBytes& log, const LogFrames& frames) {
  LogEnd end;
  std::uint64_t offset = kArisHeader;
  const auto cut_off = [&] {
    end.warning = fmt::format("{}: byte {}: the last frame is cut off; used the {} before it",
                              log.name, offset, end.frames);
    return end;
  };
  while (offset < log.size) {
    if (log.size - offset < kArisHeader) return cut_off();
    const auto bytes = log.read(offset, kArisHeader);
    if (!bytes) return bytes.error();
    const auto head = parse_aris_head(log, offset, *bytes);
    if (!head) return head.error();
    const int beams = aris_beams(head->ping_mode);
    const auto azimuths = aris_azimuths_deg(head->system, beams, head->large_lens != 0);
    if (azimuths.empty()) {
      return log_error(log, offset + kPingMode,
                       fmt::format("{} beams of an {}{}; no table of their azimuths is published",
                                   beams, system_name(head->system),
                                   head->large_lens != 0 ? " with telephoto lens" : ""));
    }
    const std::uint64_t size = static_cast<std::uint64_t>(beams) * head->samples;
    if (log.size - offset - kArisHeader < size) return cut_off();
    LogFrame frame = frame_of(*head, offset, azimuths);
    if (frames.wants_counts(end.frames)) {
      auto counts = log.read(offset + kArisHeader, size);
      if (!counts) return counts.error();
      frame.counts = std::move(*counts);
    }
    if (const Status used = frames.use(end.frames, frame); !used) return used.error();
    ++end.frames;
    offset += kArisHeader + size;
  }
  return end;
}

std::string aris_file_header(const ArisHead& first, std::uint32_t frames) {
  std::string bytes(kArisHeader, '\0');
  put_value_at(bytes, 0, kSignature);
  put_value_at(bytes, kFrameCount, frames);
  put_value_at(bytes, kHighResolution, first.high_frequency);
  put_value_at(bytes, kRawBeams, static_cast<std::uint32_t>(aris_beams(first.ping_mode)));
  put_value_at(bytes, kSamplesPerChannel, first.samples);
  put_value_at(bytes, kFileSerial, first.serial);
  put_value_at(bytes, kFileLargeLens, first.large_lens);
  return bytes;
}

std::string aris_frame_header(const ArisHead& head) {
  std::string bytes(kArisHeader, '\0');
  const float metres_per_us = head.sound_speed_m_s / 2 * 1e-6f;
  put_value_at(bytes, kFrameIndex, head.frame);
  put_value_at(bytes, kFrameTime, head.time_us);
  put_value_at(bytes, kVersion, kSignature);
  put_value_at(bytes, kSonarTime, head.time_us);
  put_value_at(bytes, kWindowStart, static_cast<float>(head.sample_start_us) * metres_per_us);
  put_value_at(bytes, kWindowLength,
               static_cast<float>(head.sample_period_us * head.samples) * metres_per_us);
  put_value_at(bytes, kDepth, head.depth_m);
  put_value_at(bytes, kPitch, head.pitch_deg);
  put_value_at(bytes, kRoll, head.roll_deg);
  put_value_at(bytes, kHeading, head.heading_deg);
  put_value_at(bytes, kSampleRate, 1e6f / static_cast<float>(head.sample_period_us));
  put_value_at(bytes, kPingMode, head.ping_mode);
  put_value_at(bytes, kFrequencyHigh, head.high_frequency);
  put_value_at(bytes, kSamplePeriod, head.sample_period_us);
  put_value_at(bytes, kSoundSpeed, head.sound_speed_m_s);
  put_value_at(bytes, kSamples, head.samples);
  put_value_at(bytes, kSampleStart, head.sample_start_us);
  put_value_at(bytes, kLargeLens, head.large_lens);
  put_value_at(bytes, kSystem, head.system);
  put_value_at(bytes, kSerial, head.serial);
  put_value_at(bytes, kReordered, std::uint32_t{1});
  return bytes;
}

}  // namespace ensonify
