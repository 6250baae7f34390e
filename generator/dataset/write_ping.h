// One ping on disk: its pictures, arrays and labels, then the record that says it is done.
//
//   ping_is_finished
//   write_ping
#pragma once

#include <cstdint>
#include <filesystem>

#include "core/error.h"
#include "core/parallel.h"
#include "core/ping.h"

namespace ensonify {

// Whether the ping's record is there and every file it lists has the size it had; or the whole
// sequence has its sequence.json, which comes after all of its pings (open_work has made sure that
// no file of it is missing).
bool ping_is_finished(const std::filesystem::path& dir, std::uint32_t sequence, std::uint32_t ping,
                      const SequenceInfo& info);

// Encodes, hashes and writes the files of a ping, each under a temporary name first, and its record
// last. Does nothing if the ping is finished: another copy of the same work was faster. May be
// called for several pings at once.
//
// Which files: `info.output` says it for timeseries, polar, cartesian and scatterers; with
// `info.output.png` the grey pictures that `result` holds. A result that lacks what it says, or
// whose sizes do not fit `info`, is an Error (bug). Error (io): a file cannot be written; what
// stands under a final name is whole.
Status write_ping(const std::filesystem::path& dir, const SequenceInfo& info,
                  const PingResult& result, const Workers& workers);

}  // namespace ensonify
