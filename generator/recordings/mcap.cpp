#include "recordings/mcap.h"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <map>
#include <set>

#include "formats/bytes.h"
#include "recordings/ros_image.h"

namespace ensonify {
namespace {

constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
constexpr std::string_view kKinds[] = {"marine_acoustic_msgs/msg/ProjectedSonarImage",
                                       "marine_acoustic_msgs/msg/RawSonarImage"};
// What the values of images mean. A proposal for the second package, made in the first.
constexpr std::string_view kInfoKinds[] = {"marine_interfaces/msg/SonarInfo",
                                           "marine_acoustic_msgs/msg/SonarInfo"};
constexpr std::uint64_t kRecordHead = 9;                       // opcode and length
constexpr std::uint64_t kMostRecord = std::uint64_t{1} << 28;  // that is read at once
constexpr std::size_t kLongestTopic = 1024;                    // ROS 2 allows 247
constexpr std::size_t kMostOthers = 32;                        // that a warning names
constexpr char kInfoEnd[] = "/info";                           // of a topic that describes another
enum Opcode : std::uint8_t {
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kDataEnd = 0x0f,
};

struct Topic {
  std::string name;
  RosImageKind kind = RosImageKind::projected;
};

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
      warn(fmt::format("byte {}: the file is cut off; used the {} images before it", offset,
                       end_.frames));
    }
    if (!others_.empty()) {
      warn(fmt::format("used topic {}; others with images: {}", topic_, others_));
    }
    const auto info = infos_.find(topic_ + kInfoEnd);
    if (info != infos_.end() && info->second.kind == RosScale::Kind::unknown && !choices_.db) {
      warn(
          fmt::format("{} does not say what the counts mean; used them as amplitudes (--db "
                      "LOW:HIGH reads them as levels)",
                      info->first));
    }
    return end_;
  }

 private:
  void warn(const std::string& what) {
    end_.warning += fmt::format("{}{}: {}", end_.warning.empty() ? "" : "\n", log_.name, what);
  }

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
    cursor.take(8 + 8);  // times
    const auto uncompressed = cursor.number<std::uint64_t>();
    cursor.take(4);  // checksum
    const std::string_view compression = cursor.text();
    const auto size = cursor.number<std::uint64_t>();
    const std::uint64_t start = cursor.at();
    const std::string_view records = cursor.take(size);
    if (!cursor.whole()) return log_error(log_, offset, "a chunk that is shorter than it says");
    if (compression.empty()) return records_of(offset + start, records, true);
    const auto inner = decompressed(compression, records, uncompressed);
    if (!inner) return log_error(log_, offset, inner.error().message);
    return records_of(offset, *inner, false);
  }

  // `offset`: of the first record or, of a compressed chunk, of the chunk.
  Status records_of(std::uint64_t offset, std::string_view records, bool in_file) {
    for (std::uint64_t at = 0; at < records.size();) {
      Cursor head(records.substr(at), false);
      const auto opcode = head.number<std::uint8_t>();
      const std::string_view inner = head.take(head.number<std::uint64_t>());
      if (!head.whole()) {
        return log_error(log_, in_file ? offset + at : offset,
                         "a record beyond the end of its chunk");
      }
      const Status used = record(in_file ? offset + at + kRecordHead : offset, opcode, inner);
      if (!used) return used;
      at += head.at();
    }
    return {};
  }

  Status record(std::uint64_t offset, std::uint8_t opcode, std::string_view content) {
    Cursor cursor(content, false);
    if (opcode == kSchema) {
      const auto id = cursor.number<std::uint16_t>();
      const std::string_view name = cursor.text();
      if (std::find(std::begin(kInfoKinds), std::end(kInfoKinds), name) != std::end(kInfoKinds)) {
        info_schemas_.insert(id);
      }
      const auto* const kind = std::find(std::begin(kKinds), std::end(kKinds), name);
      if (kind != std::end(kKinds))
        schemas_[id] = kind == kKinds ? RosImageKind::projected : RosImageKind::raw;
    } else if (opcode == kChannel) {
      const auto id = cursor.number<std::uint16_t>();
      const auto schema = cursor.number<std::uint16_t>();
      const std::string_view topic = cursor.text();
      if (topic.size() > kLongestTopic) {
        return log_error(log_, offset,
                         fmt::format("a topic whose name has {} bytes; expected at most {}",
                                     topic.size(), kLongestTopic));
      }
      if (cursor.whole() && info_schemas_.count(schema) > 0) info_topics_[id] = topic;
      const auto kind = schemas_.find(schema);
      if (cursor.whole() && kind != schemas_.end())
        topics_[id] = {std::string(topic), kind->second};
    } else if (opcode == kMessage) {
      const auto channel = cursor.number<std::uint16_t>();
      cursor.take(4);  // sequence
      const auto log_time_ns = cursor.number<std::uint64_t>();
      cursor.take(8);  // time of publishing
      if (!cursor.whole()) return log_error(log_, offset, "a message without its head");
      if (const auto info = info_topics_.find(channel); info != info_topics_.end()) {
        return info_message(offset, info->second, content.substr(cursor.at()));
      }
      if (is_read(channel)) {
        // Of a compressed chunk, the offset is that of the chunk.
        return message(offset, topics_[channel].kind, content.substr(cursor.at()), log_time_ns);
      }
    }
    return {};
  }

  // Whether messages of the channel are read: those of the topic that was asked for, or of the
  // first one that has a message.
  bool is_read(std::uint16_t channel) {
    const auto found = topics_.find(channel);
    if (found == topics_.end()) return false;
    const std::string& name = found->second.name;
    if (topic_.empty()) topic_ = name;
    if (name == topic_) return true;
    if (choices_.topic.empty() && seen_.size() < kMostOthers && seen_.insert(name).second) {
      others_ += (others_.empty() ? "" : ", ") + (seen_.size() < kMostOthers ? name : "and more");
    }
    return false;
  }

  // The description of TOPIC is TOPIC/info.
  Status info_message(std::uint64_t offset, const std::string& topic, std::string_view bytes) {
    auto scale = parse_sonar_info(log_, offset, bytes);
    if (!scale) return scale.error();
    const bool late = end_.frames > 0 && topic == topic_ + kInfoEnd && infos_.count(topic) == 0;
    if (late && !choices_.db && scale->kind == RosScale::Kind::db) {
      return log_error(log_, offset,
                       fmt::format("{} says that the counts are in dB, after {} images without it; "
                                   "expected --db LOW:HIGH for all of them",
                                   topic, end_.frames));
    }
    infos_[topic] = *scale;
    return {};
  }

  Status message(std::uint64_t offset, RosImageKind kind, std::string_view bytes,
                 std::uint64_t log_time_ns) {
    const auto found = infos_.find(topic_ + kInfoEnd);
    const RosValues values{topic_, choices_.db,
                           found == infos_.end() ? std::nullopt : std::optional(found->second)};
    auto frame =
        parse_ros_image(log_, offset, kind, bytes, values, frames_.wants_counts(end_.frames));
    if (!frame) return frame.error();
    if (frame->time_us == 0) frame->time_us = static_cast<std::int64_t>(log_time_ns / 1000);
    frame->settings.instrument = "topic " + topic_;
    return frames_.use(end_.frames++, *frame);
  }

  const LogBytes& log_;
  const LogFrames& frames_;
  const LogChoices& choices_;
  std::string topic_;                              // that is read; empty: not known yet
  std::string others_;                             // that are not
  std::map<std::uint16_t, RosImageKind> schemas_;  // of images
  std::map<std::uint16_t, Topic> topics_;          // of channels with images
  std::set<std::uint16_t> info_schemas_;
  std::map<std::uint16_t, std::string> info_topics_;  // of channels
  std::map<std::string, RosScale> infos_;             // the last one of each topic
  std::set<std::string> seen_;
  LogEnd end_;
};

}  // namespace

bool is_mcap(std::string_view bytes) {
  return bytes.size() >= 4 && bytes.substr(0, 4) == kMagic.substr(0, 4);
}

Result<LogEnd> read_mcap(const LogBytes& log, const LogFrames& frames, const LogChoices& choices) {
  auto end = Reader(log, frames, choices).run();
  if (!end || end->frames > 0) return end;
  return log_error(log, log.size,
                   choices.topic.empty()
                       ? fmt::format("no message of type {} or {}", kKinds[0], kKinds[1])
                       : fmt::format("no message of type {} or {} on topic {}", kKinds[0],
                                     kKinds[1], choices.topic));
}

namespace {

// Of a byte, at best: a run of 255 bytes; a block of 128 KiB that takes four bytes.
constexpr std::uint64_t kMostOfByteLz4 = 255, kMostOfByteZstd = 32'768;

struct Lz4Reader {
  LZ4F_dctx* context = nullptr;
  Lz4Reader() {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) context = nullptr;
  }
  ~Lz4Reader() { LZ4F_freeDecompressionContext(context); }
  Lz4Reader(const Lz4Reader&) = delete;
  Lz4Reader& operator=(const Lz4Reader&) = delete;
};

// Whether the bytes are one or more whole frames that fill `out`, neither more nor less.
bool read_lz4(std::string_view bytes, std::string& out) {
  Lz4Reader reader;
  if (reader.context == nullptr) return false;
  std::size_t at = 0, filled = 0, hint = 0;  // 0: at the end of a frame
  while (at < bytes.size()) {
    std::size_t taken = bytes.size() - at, made = out.size() - filled;
    hint = LZ4F_decompress(reader.context, out.data() + filled, &made, bytes.data() + at, &taken,
                           nullptr);
    if (LZ4F_isError(hint) || (taken == 0 && made == 0)) return false;
    at += taken;
    filled += made;
  }
  return filled == out.size() && hint == 0;
}

bool read_zstd(std::string_view bytes, std::string& out) {
  const std::size_t made = ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
  return !ZSTD_isError(made) && made == out.size();
}

}  // namespace

Result<std::string> decompressed(std::string_view compression, std::string_view bytes,
                                 std::uint64_t size) {
  const auto refused = [](const std::string& what) { return Error{ErrorKind::usage, what}; };
  const bool lz4 = compression == "lz4";
  if (!lz4 && compression != "zstd") {
    return refused(
        "a chunk of another compression than lz4 and zstd; `mcap decompress` writes the "
        "file without compression");
  }
  if (size > kMostChunk || size / (lz4 ? kMostOfByteLz4 : kMostOfByteZstd) > bytes.size()) {
    return refused(
        fmt::format("a chunk of {} bytes, compressed to {}; expected at most {}, and no "
                    "more than the compression can hold",
                    size, bytes.size(), kMostChunk));
  }
  std::string out(size, '\0');
  if (lz4 ? read_lz4(bytes, out) : read_zstd(bytes, out)) return out;
  return refused(fmt::format("a damaged chunk ({})", compression));
}

}  // namespace ensonify
