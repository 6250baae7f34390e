// One ping on disk: its images, arrays and labels, then the record that says it is done.
//
//   ping_is_finished
//   encode_ping  store_ping   the work of the processor and that of the disk
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

// Whether the ping's record is there and every file it lists has the size it had; or the whole
// sequence has its sequence.json, which comes after all of its pings (open_work has made sure that
// no file of it is missing).
bool ping_is_finished(const std::filesystem::path& dir, std::uint32_t sequence, std::uint32_t ping,
                      const SequenceInfo& info);

struct EncodedFile {
  std::string name_template;  // see layout.h
  FileEntry entry;            // its path relative to the sequence's folder
  std::string bytes;
};

// All that goes to the disk of one ping, hashed.
struct EncodedPing {
  std::uint32_t ping = 0;
  std::vector<EncodedFile> files;
  std::string record;
};

// Which files: `info.output` says it for timeseries, polar, cartesian and scatterers; with
// `info.output.png` the gray images that `result` holds. A result that lacks what it says, or
// whose sizes do not fit `info`, is an Error (bug).
Result<EncodedPing> encode_ping(const SequenceInfo& info, const PingResult& result,
                                const Workers& workers);

// Writes the files, each under a temporary name first, and the record last. Does nothing if the
// ping is finished: another copy of the same work was faster. May be called for several pings at
// once. Error (io): a file cannot be written; what stands under a final name is whole.
Status store_ping(const std::filesystem::path& dir, const SequenceInfo& info,
                  const EncodedPing& encoded);

Status write_ping(const std::filesystem::path& dir, const SequenceInfo& info,
                  const PingResult& result, const Workers& workers);

}  // namespace ensonify
