// An MCAP file (https://mcap.dev/spec), written in one pass: messages in uncompressed chunks, each
// with an index, then a summary, with all checksums of the format. Private to export/.
//
//   McapFile       add_schema add_channel add_metadata write close
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "formats/files.h"

namespace ensonify {

class McapFile {
 public:
  McapFile(const std::filesystem::path& path, std::string_view profile, std::string_view library);

  // Both before the first message of the channel; numbers count from 1.
  std::uint16_t add_schema(std::string_view name, std::string_view encoding, std::string_view text);
  std::uint16_t add_channel(std::uint16_t schema, std::string_view topic,
                            std::string_view message_encoding,
                            const std::map<std::string, std::string>& metadata);
  void add_metadata(std::string_view name, const std::map<std::string, std::string>& values);
  // Times must not decrease; `sequence` counts the messages of a channel.
  void write(std::uint16_t channel, std::uint32_t sequence, std::uint64_t time_ns,
             std::string_view data);
  // Error (io): the file cannot be written.
  Status close();

 private:
  struct ChunkIndex {
    std::uint64_t first_ns = 0, last_ns = 0, start = 0, length = 0, index_length = 0, size = 0;
    std::map<std::uint16_t, std::uint64_t> index_offsets;  // by channel
  };

  void put(std::string_view bytes);
  void put_record(std::uint8_t opcode, std::string_view content);
  void end_chunk();
  std::string chunk_index_records() const;
  std::string statistics_record() const;

  StreamedFile file_;
  std::uint32_t crc_ = 0;                              // of all that was put
  std::string schemas_, channels_, metadata_indices_;  // records, for the summary
  std::uint16_t schema_count_ = 0, channel_count_ = 0;
  std::string chunk_;  // records of the chunk under way
  std::uint64_t chunk_first_ns_ = 0, chunk_last_ns_ = 0;
  // By channel: time and offset in the chunk of each message.
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> chunk_messages_;
  std::vector<ChunkIndex> chunks_;
  std::map<std::uint16_t, std::uint64_t> message_counts_;
  std::uint64_t first_ns_ = 0, last_ns_ = 0, messages_ = 0;
  std::uint32_t metadata_count_ = 0;
};

}  // namespace ensonify
