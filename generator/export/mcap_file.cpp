#include "export/mcap_file.h"

#include "formats/bytes.h"
#include "formats/deflate.h"

namespace ensonify {
namespace {

enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0b,
  kMetadata = 0x0c,
  kMetadataIndex = 0x0d,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f,
};

constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

// Fields one after another, little-endian, as the format packs them.
class Fields {
 public:
  template <class T>
  Fields& number(T value) {
    put_value(text_, value);
    return *this;
  }
  Fields& string(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    text_ += text;
    return *this;
  }
  Fields& raw(std::string_view bytes) {
    text_ += bytes;
    return *this;
  }
  Fields& texts(const std::map<std::string, std::string>& map) {
    Fields pairs;
    for (const auto& [key, value] : map) pairs.string(key).string(value);
    return string(pairs.text());
  }
  Fields& counts(const std::map<std::uint16_t, std::uint64_t>& map) {
    number(static_cast<std::uint32_t>(map.size() * 10));
    for (const auto& [key, value] : map) number(key).number(value);
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string record(std::uint8_t opcode, std::string_view content) {
  return Fields().number(opcode).number(std::uint64_t{content.size()}).raw(content).text();
}

}  // namespace

McapFile::McapFile(const std::filesystem::path& path, std::string_view profile,
                   std::string_view library)
    : file_(path) {
  put(kMagic);
  put_record(kHeader, Fields().string(profile).string(library).text());
}

void McapFile::put(std::string_view bytes) {
  crc_ = crc32_of(bytes, crc_);
  file_.append(bytes);
}

void McapFile::put_record(std::uint8_t opcode, std::string_view content) {
  put(Fields().number(opcode).number(std::uint64_t{content.size()}).text());
  put(content);
}

std::uint16_t McapFile::add_schema(std::string_view name, std::string_view encoding,
                                   std::string_view text) {
  const std::string content =
      Fields().number(++schema_count_).string(name).string(encoding).string(text).text();
  put_record(kSchema, content);
  schemas_ += record(kSchema, content);
  return schema_count_;
}

std::uint16_t McapFile::add_channel(std::uint16_t schema, std::string_view topic,
                                    std::string_view message_encoding,
                                    const std::map<std::string, std::string>& metadata) {
  const std::string content = Fields()
                                  .number(++channel_count_)
                                  .number(schema)
                                  .string(topic)
                                  .string(message_encoding)
                                  .texts(metadata)
                                  .text();
  put_record(kChannel, content);
  channels_ += record(kChannel, content);
  message_counts_[channel_count_] = 0;
  return channel_count_;
}

void McapFile::add_metadata(std::string_view name,
                            const std::map<std::string, std::string>& values) {
  const std::uint64_t start = file_.bytes();
  put_record(kMetadata, Fields().string(name).texts(values).text());
  metadata_indices_ += record(
      kMetadataIndex, Fields().number(start).number(file_.bytes() - start).string(name).text());
  ++metadata_count_;
}

void McapFile::write(std::uint16_t channel, std::uint32_t sequence, std::uint64_t time_ns,
                     std::string_view data) {
  ENSONIFY_ASSERT(messages_ == 0 || time_ns >= last_ns_);
  if (chunk_.empty()) chunk_first_ns_ = time_ns;
  if (messages_ == 0) first_ns_ = time_ns;
  chunk_last_ns_ = last_ns_ = time_ns;
  ++messages_;
  ++message_counts_[channel];
  chunk_messages_[channel].emplace_back(time_ns, chunk_.size());
  chunk_ += record(
      kMessage,
      Fields().number(channel).number(sequence).number(time_ns).number(time_ns).raw(data).text());
  if (chunk_.size() >= kChunkBytes) end_chunk();
}

void McapFile::end_chunk() {
  if (chunk_.empty()) return;
  ChunkIndex index{chunk_first_ns_, chunk_last_ns_, file_.bytes(), 0, 0, chunk_.size(), {}};
  put_record(kChunk, Fields()
                         .number(chunk_first_ns_)
                         .number(chunk_last_ns_)
                         .number(std::uint64_t{chunk_.size()})
                         .number(crc32_of(chunk_))
                         .string("")
                         .number(std::uint64_t{chunk_.size()})
                         .raw(chunk_)
                         .text());
  index.length = file_.bytes() - index.start;
  for (const auto& [channel, messages] : chunk_messages_) {
    index.index_offsets[channel] = file_.bytes();
    Fields entries;
    for (const auto& [time_ns, offset] : messages) entries.number(time_ns).number(offset);
    put_record(kMessageIndex, Fields().number(channel).string(entries.text()).text());
  }
  index.index_length = file_.bytes() - index.start - index.length;
  chunks_.push_back(std::move(index));
  chunk_.clear();
  chunk_messages_.clear();
}

std::string McapFile::chunk_index_records() const {
  std::string records;
  for (const ChunkIndex& chunk : chunks_) {
    records += record(kChunkIndex, Fields()
                                       .number(chunk.first_ns)
                                       .number(chunk.last_ns)
                                       .number(chunk.start)
                                       .number(chunk.length)
                                       .counts(chunk.index_offsets)
                                       .number(chunk.index_length)
                                       .string("")
                                       .number(chunk.size)
                                       .number(chunk.size)
                                       .text());
  }
  return records;
}

std::string McapFile::statistics_record() const {
  return record(kStatistics, Fields()
                                 .number(messages_)
                                 .number(schema_count_)
                                 .number(std::uint32_t{channel_count_})
                                 .number(std::uint32_t{0})  // attachments
                                 .number(metadata_count_)
                                 .number(static_cast<std::uint32_t>(chunks_.size()))
                                 .number(first_ns_)
                                 .number(last_ns_)
                                 .counts(message_counts_)
                                 .text());
}

Status McapFile::close() {
  end_chunk();
  const std::uint32_t data_crc = crc_;
  put_record(kDataEnd, Fields().number(data_crc).text());

  const std::uint64_t summary_start = file_.bytes();
  crc_ = 0;
  const std::pair<Opcode, std::string> groups[] = {{kSchema, schemas_},
                                                   {kChannel, channels_},
                                                   {kStatistics, statistics_record()},
                                                   {kChunkIndex, chunk_index_records()},
                                                   {kMetadataIndex, metadata_indices_}};
  std::string offsets;
  for (const auto& [opcode, records] : groups) {
    if (records.empty()) continue;
    offsets += record(kSummaryOffset, Fields()
                                          .number(static_cast<std::uint8_t>(opcode))
                                          .number(file_.bytes())
                                          .number(std::uint64_t{records.size()})
                                          .text());
    put(records);
  }
  const std::uint64_t offsets_start = file_.bytes();
  put(offsets);
  // The checksum covers the footer up to itself.
  put(Fields()
          .number(static_cast<std::uint8_t>(kFooter))
          .number(std::uint64_t{20})
          .number(summary_start)
          .number(offsets_start)
          .text());
  const std::uint32_t summary_crc = crc_;
  put(Fields().number(summary_crc).text());
  put(kMagic);
  return file_.close();
}

}  // namespace ensonify
