// Arrays of all pings of a sequence, with `output.one_file_per: sequence`. While pings are made,
// each has a piece: its part of every array, one behind the other. Finishing the sequence strings
// them together; catalogue.h says which there are. Private to dataset/.
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

// The pieces, and their folder if nothing else is in it. Nothing happens where there are none.
void remove_pieces(const std::filesystem::path& dir, std::uint32_t sequence);

}  // namespace ensonify
