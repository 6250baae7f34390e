#include "recordings/mcap.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "core/vec.h"
#include "formats/bytes.h"

namespace ensonify {
namespace {

constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
constexpr std::string_view kImage = "marine_acoustic_msgs/msg/ProjectedSonarImage";
constexpr std::uint64_t kRecordHead = 9;                       // opcode and length
constexpr std::uint64_t kMostRecord = std::uint64_t{1} << 28;  // that is read at once
enum Opcode : std::uint8_t {
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kDataEnd = 0x0f,
};

// Values one after another. Once a value goes beyond the bytes, all are 0 and `whole` is false.
class Cursor {
 public:
  // CDR aligns numbers to their size; MCAP does not.
  Cursor(std::string_view bytes, bool aligned) : bytes_(bytes), aligned_(aligned) {}

  template <class T>
  T number() {
    if (aligned_) skip((sizeof(T) - at_ % sizeof(T)) % sizeof(T));
    const std::string_view raw = take(sizeof(T));
    return whole_ ? value_at<T>(raw, 0) : T{};
  }
  std::string_view take(std::uint64_t count) {
    if (!whole_ || count > bytes_.size() - at_) {
      whole_ = false;
      return {};
    }
    const std::string_view taken = bytes_.substr(at_, count);
    at_ += count;
    return taken;
  }
  std::string_view text() { return take(number<std::uint32_t>()); }
  // The bytes of an array of such numbers.
  template <class T>
  std::string_view array() {
    const std::uint64_t count = number<std::uint32_t>();
    if (aligned_ && count > 0) skip((sizeof(T) - at_ % sizeof(T)) % sizeof(T));
    return take(count * sizeof(T));
  }
  bool whole() const { return whole_; }
  std::uint64_t at() const { return at_; }

 private:
  void skip(std::uint64_t count) { take(count); }

  std::string_view bytes_;
  std::uint64_t at_ = 0;
  bool aligned_, whole_ = true;
};

struct Projected {
  std::int64_t time_us = 0;
  float frequency_hz = 0, sound_speed_m_s = 0;
  std::vector<double> directions;  // x, y, z of each beam
  std::vector<float> ranges_m;
  bool big_endian = false;
  std::uint32_t type = 0, beams = 0;
  std::string_view data;
};

// None if the message is shorter than its members.
std::optional<Projected> members_of(std::string_view cdr) {
  Cursor cursor(cdr, true);
  Projected image;
  const std::int64_t seconds = cursor.number<std::int32_t>();
  image.time_us = seconds * 1'000'000 + cursor.number<std::uint32_t>() / 1000;
  cursor.text();  // frame
  image.frequency_hz = cursor.number<float>();
  image.sound_speed_m_s = cursor.number<float>();
  cursor.array<float>();  // beam widths
  cursor.array<float>();
  const std::uint64_t beams = cursor.number<std::uint32_t>();
  if (beams > kMostLogBeams) return std::nullopt;
  for (std::uint64_t i = 0; i < 3 * beams; ++i) image.directions.push_back(cursor.number<double>());
  image.ranges_m = values_in<float>(cursor.array<float>());
  image.big_endian = cursor.number<std::uint8_t>() != 0;
  image.type = cursor.number<std::uint32_t>();
  image.beams = cursor.number<std::uint32_t>();
  image.data = cursor.array<std::uint8_t>();
  return cursor.whole() ? std::optional(std::move(image)) : std::nullopt;
}

// What is wrong with the numbers; empty: nothing. Fills axes and numbers of the settings.
std::string take_settings(const Projected& image, LogSettings& settings) {
  const std::size_t beams = image.directions.size() / 3, samples = image.ranges_m.size();
  if (image.type != 0 && image.type != 2) {
    return fmt::format("data type {}; expected 0 (UINT8) or 2 (UINT16)", image.type);
  }
  settings.bits = image.type == 0 ? 8 : 16;
  if (beams < 2 || samples < 2 || samples > kMostLogSamples || image.beams != beams) {
    return fmt::format(
        "{} directions, {} ranges and a beam count of {}; expected one direction "
        "per beam, and at least 2 beams and ranges",
        beams, samples, image.beams);
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
  if (!(settings.sound_speed_m_s >= 1000 && settings.sound_speed_m_s <= 2000)) {
    settings.sound_speed_m_s = 1500;  // drivers leave it out
  }
  const double first = double{image.ranges_m.front()}, last = double{image.ranges_m.back()};
  const double step = (last - first) / static_cast<double>(samples - 1);
  if (!(first >= 0 && first < 1e5 && step > 0 && step < 1000 && first / step < 1e6)) {
    return fmt::format("ranges from {} to {} m", first, last);
  }
  for (std::size_t i = 0; i < samples; ++i) {
    const double even = first + static_cast<double>(i) * step;
    if (!(std::abs(double{image.ranges_m[i]} - even) <= step / 4)) {
      return "ranges that are not equally spaced, as data sets need them";
    }
  }
  settings.first_range_m = first;
  settings.range_step_m = step;
  return {};
}

// The message's frame has z ahead, x up and y to starboard.
std::string take_azimuths(const Projected& image, LogSettings& settings) {
  auto& azimuths = settings.azimuth_rad;
  for (std::size_t i = 0; i < image.directions.size(); i += 3) {
    azimuths.push_back(std::atan2(-image.directions[i + 1], image.directions[i + 2]));
    if (!std::isfinite(azimuths.back())) return "a direction that is not a number";
  }
  for (std::size_t i = 1; i < azimuths.size(); ++i) {
    const bool rising = azimuths[0] < azimuths[1];
    if ((azimuths[i - 1] < azimuths[i]) == rising && azimuths[i - 1] != azimuths[i]) continue;
    return fmt::format("directions of beams {} and {} that do not rise or fall in azimuth", i - 1,
                       i);
  }
  return {};
}

std::string counts_of(const Projected& image, const LogSettings& settings, bool reversed) {
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

class Reader {
 public:
  Reader(const LogBytes& log, const LogFrames& frames, const LogChoices& choices)
      : log_(log), frames_(frames), choices_(choices), topic_(choices.topic) {}

  Result<LogEnd> run() {
    std::uint64_t offset = kMagic.size();
    bool ended = false;
    while (!ended && offset < log_.size) {
      if (log_.size - offset < kRecordHead) break;
      const auto head = log_.read(offset, kRecordHead);
      if (!head) return head.error();
      const auto opcode = value_at<std::uint8_t>(*head, 0);
      const auto length = value_at<std::uint64_t>(*head, 1);
      if (length > log_.size - offset - kRecordHead) break;
      if (const Status used = record_at(offset + kRecordHead, opcode, length); !used) {
        return used.error();
      }
      ended = opcode == kDataEnd || opcode == kFooter;
      offset += kRecordHead + length;
    }
    if (!ended) {
      end_.warning = fmt::format("{}: byte {}: the file is cut off; used the {} images before it",
                                 log_.name, offset, end_.frames);
    }
    if (!others_.empty()) {
      end_.warning += fmt::format("{}{}: used topic {}; others with images: {}",
                                  end_.warning.empty() ? "" : "\n", log_.name, topic_, others_);
    }
    return end_;
  }

 private:
  // A record of the file, whose content begins at `offset`.
  Status record_at(std::uint64_t offset, std::uint8_t opcode, std::uint64_t length) {
    const bool used =
        opcode == kSchema || opcode == kChannel || opcode == kMessage || opcode == kChunk;
    if (!used) return {};
    if (length > kMostRecord) {
      return log_error(
          log_, offset,
          fmt::format("a record of {} bytes; expected at most {}", length, kMostRecord));
    }
    const auto content = log_.read(offset, length);
    if (!content) return content.error();
    return opcode == kChunk ? chunk(offset, *content) : record(offset, opcode, *content);
  }

  Status chunk(std::uint64_t offset, std::string_view content) {
    Cursor cursor(content, false);
    cursor.take(8 + 8 + 8 + 4);  // times, size and checksum
    const std::string_view compression = cursor.text();
    const auto size = cursor.number<std::uint64_t>();
    const std::uint64_t start = cursor.at();
    const std::string_view records = cursor.take(size);
    if (!cursor.whole()) return log_error(log_, offset, "a chunk that is shorter than it says");
    if (!compression.empty()) {
      return log_error(log_, offset,
                       fmt::format("chunks are compressed ({}); `mcap decompress` writes the file "
                                   "without compression",
                                   compression.substr(0, 16)));
    }
    for (std::uint64_t at = 0; at < records.size();) {
      Cursor head(records.substr(at), false);
      const auto opcode = head.number<std::uint8_t>();
      const std::string_view inner = head.take(head.number<std::uint64_t>());
      if (!head.whole()) {
        return log_error(log_, offset + start + at, "a record beyond the end of its chunk");
      }
      const Status used = record(offset + start + at + kRecordHead, opcode, inner);
      if (!used) return used;
      at += head.at();
    }
    return {};
  }

  Status record(std::uint64_t offset, std::uint8_t opcode, std::string_view content) {
    Cursor cursor(content, false);
    if (opcode == kSchema) {
      const auto id = cursor.number<std::uint16_t>();
      if (cursor.text() == kImage) image_schemas_.insert(id);
    } else if (opcode == kChannel) {
      const auto id = cursor.number<std::uint16_t>();
      const auto schema = cursor.number<std::uint16_t>();
      const std::string topic(cursor.text());
      if (cursor.whole() && image_schemas_.contains(schema)) topics_[id] = topic;
    } else if (opcode == kMessage) {
      const auto channel = cursor.number<std::uint16_t>();
      cursor.take(4);  // sequence
      const auto log_time_ns = cursor.number<std::uint64_t>();
      cursor.take(8);  // time of publishing
      if (!cursor.whole()) return log_error(log_, offset, "a message without its head");
      if (is_read(channel)) {
        return message(offset + cursor.at(), content.substr(cursor.at()), log_time_ns);
      }
    }
    return {};
  }

  // Whether messages of the channel are read: those of the topic that was asked for, or of the
  // first one that has a message.
  bool is_read(std::uint16_t channel) {
    const auto found = topics_.find(channel);
    if (found == topics_.end()) return false;
    if (topic_.empty()) topic_ = found->second;
    if (found->second == topic_) return true;
    if (choices_.topic.empty() && seen_.insert(found->second).second) {
      others_ += (others_.empty() ? "" : ", ") + found->second;
    }
    return false;
  }

  Status message(std::uint64_t offset, std::string_view bytes, std::uint64_t log_time_ns) {
    auto frame = parse_projected(log_, offset, bytes, frames_.wants_counts(end_.frames));
    if (!frame) return frame.error();
    if (frame->time_us == 0) frame->time_us = static_cast<std::int64_t>(log_time_ns / 1000);
    frame->settings.instrument = "topic " + topic_;
    frame->settings.db = choices_.db;
    return frames_.use(end_.frames++, *frame);
  }

  const LogBytes& log_;
  const LogFrames& frames_;
  const LogChoices& choices_;
  std::string topic_;   // that is read; empty: not known yet
  std::string others_;  // that are not
  std::set<std::uint16_t> image_schemas_;
  std::map<std::uint16_t, std::string> topics_;  // of channels with images
  std::set<std::string> seen_;
  LogEnd end_;
};

}  // namespace

bool is_mcap(std::string_view bytes) {
  return bytes.size() >= 4 && bytes.substr(0, 4) == kMagic.substr(0, 4);
}

Result<LogFrame> parse_projected(const LogBytes& log, std::uint64_t offset,
                                 std::string_view message, bool with_counts) {
  constexpr std::size_t kHeader = 4;
  if (message.size() < kHeader || message.substr(0, 2) != std::string_view("\0\1", 2)) {
    return log_error(log, offset, "a message that is not CDR, little-endian (00 01)");
  }
  const auto image = members_of(message.substr(kHeader));
  if (!image) return log_error(log, offset, "an image that is shorter than its members");
  LogFrame frame;
  frame.offset = offset;
  frame.time_us = image->time_us;
  LogSettings& settings = frame.settings;
  std::string fault = take_settings(*image, settings);
  if (fault.empty()) fault = take_azimuths(*image, settings);
  if (!fault.empty()) return log_error(log, offset, fault);
  auto& azimuths = settings.azimuth_rad;
  const bool reversed = azimuths[0] > azimuths[1];
  if (reversed) std::reverse(azimuths.begin(), azimuths.end());
  if (with_counts) frame.counts = counts_of(*image, settings, reversed);
  return frame;
}

Result<LogEnd> read_mcap(const LogBytes& log, const LogFrames& frames, const LogChoices& choices) {
  auto end = Reader(log, frames, choices).run();
  if (!end || end->frames > 0) return end;
  return log_error(log, log.size,
                   choices.topic.empty()
                       ? fmt::format("no message of type {}", kImage)
                       : fmt::format("no message of type {} on topic {}", kImage, choices.topic));
}

}  // namespace ensonify
