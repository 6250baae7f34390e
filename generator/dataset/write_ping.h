// One ping on disk: its images, arrays and labels, then the record that says it is done.
//
//   ping_is_finished
//   encode_ping  store_ping   processor work and disk work
//   write_ping                both
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "core/ping.h"
#include "formats/files.h"

namespace ensonify {

// Whether the ping's record exists and every file it lists has its size, or the sequence has its
// sequence.json, which is written after all pings (open_work made sure that none of its files is
// missing).
bool ping_is_finished(const std::filesystem::path& dir, std::uint32_t sequence, std::uint32_t ping,
                      const SequenceInfo& info);

struct EncodedFile {
  std::string name_template;  // see layout.h
  FileEntry entry;            // its path relative to the sequence's folder
  std::string bytes;
};

// All files of one ping, hashed.
struct EncodedPing {
  std::uint32_t ping = 0;
  std::vector<EncodedFile> files;
  std::string record;
};

// `info.output` selects the files; with `info.output.png` also the 8-bit images in `result`. A
// result that lacks a selected part, or whose sizes do not match `info`, is an Error (bug).
Result<EncodedPing> encode_ping(const SequenceInfo& info, const PingResult& result,
                                const Workers& workers);

// Writes the files, each under a temporary name first, and the record last. Does nothing if another
// process with the same work has finished the ping. May be called for several pings at once. Error
// (io): a file cannot be written; files with final names are complete.
Status store_ping(const std::filesystem::path& dir, const SequenceInfo& info,
                  const EncodedPing& encoded);

Status write_ping(const std::filesystem::path& dir, const SequenceInfo& info,
                  const PingResult& result, const Workers& workers);

}  // namespace ensonify
