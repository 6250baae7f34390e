// The record of a finished ping in .work: everything that the finishing step needs, so that it
// never opens the ping's files. Private to dataset/.
//
//   record_of  to_text  parse_ping_record  read_ping_record  files_are_there
//   annotations_schema   the JSON Schema of a line of annotations.jsonl, without titles and meanings
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/ping.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {

struct PingRecord {
  std::uint32_t ping = 0;
  double time_s = 0;
  Pose sonar_in_world;
  std::vector<Pose> object_in_world;
  std::vector<float> first_return_m;  // NaN: none
  DisplayCounts grey_counts;          // of its 8-bit polar image
  std::string annotations;            // the ping's line of annotations.jsonl (coco.h)
  std::vector<FileEntry> files;       // relative to the sequence's folder
};

Json annotations_schema();

PingRecord record_of(const SequenceInfo& info, const PingResult& result,
                     std::vector<FileEntry> files);

// The content of its file: a line of JSON without the annotations, the line of annotations, which
// finishing copies without parsing, and the hash of both, so that damage to them does not reach the
// data set.
std::string to_text(const PingRecord& record);

// The inverse; none if the text is not a complete record.
std::optional<PingRecord> parse_ping_record(std::string_view text);

// Error (io): it cannot be read; (damage): it is not a record of that ping, or
// not whole.
Result<PingRecord> read_ping_record(const std::filesystem::path& dir, std::uint32_t sequence,
                                    std::uint32_t ping);

// Whether every file of the record exists with its size.
bool files_are_there(const std::filesystem::path& dir, std::uint32_t sequence,
                     const PingRecord& record);

}  // namespace ensonify
