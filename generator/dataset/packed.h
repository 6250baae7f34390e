// Arrays of all pings of a sequence, with `output.one_file_per: sequence`. While pings are made,
// each has a piece: its parts of all arrays, one after another. Finishing the sequence joins the
// pieces; catalogue.h lists the arrays. Private to dataset/.
//
//   encode_piece                      a ping's parts
//   write_arrays  remove_pieces       pieces -> arrays
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/ping.h"
#include "formats/files.h"

namespace ensonify {

// Needs a result that fits `info` (write_ping.h).
std::string encode_piece(const SequenceInfo& info, const PingResult& result);

// Writes the arrays from the pieces of all pings, holding little of them at once.
// Error (io): a piece is missing or short, or an array cannot be written.
Result<std::vector<FileEntry>> write_arrays(const std::filesystem::path& dir,
                                            const SequenceInfo& info);

// Removes the pieces, and their folder if it is then empty. Does nothing if there are none.
void remove_pieces(const std::filesystem::path& dir, std::uint32_t sequence);

}  // namespace ensonify
