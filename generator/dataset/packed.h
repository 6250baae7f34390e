// Arrays of all pings of a sequence, with `output.pack: sequence`. While pings are made, each has
// a piece: its part of every array, one behind the other. Finishing the sequence strings them
// together. Private to dataset/.
//
//   PackedArray  packed_arrays        what a sequence has
//   packed_form                       what an array of that name is
//   encode_piece                      a ping's parts
//   write_arrays  remove_pieces       pieces -> arrays
//   image_array                       which array a picture is in
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/ping.h"
#include "dataset/files.h"
#include "dataset/npy.h"

namespace ensonify {

struct PackedArray {
  std::string file;   // polar_level_db.npy, in the sequence's folder
  std::string descr;  // npy.h
  NpyShape shape;     // of one ping; the file's has the pings before it

  std::uint64_t ping_bytes() const;
};

// In the order in which they lie in a piece.
std::vector<PackedArray> packed_arrays(const SequenceInfo& info);

// The shapes of a ping: [beams, samples], [elements, samples], [samples, beams], [rows, columns].
enum class PackedGrid { series, channels, polar, cartesian };
struct PackedForm {
  std::string descr;
  PackedGrid grid = PackedGrid::series;
};
// None if no data set has an array of this file name.
std::optional<PackedForm> packed_form(std::string_view file);

// Needs a result that fits `info` (write_ping.h).
std::string encode_piece(const SequenceInfo& info, const PingResult& result);

// Writes the arrays from the pieces of all pings, holding little of them at once.
// Error (io): a piece is missing or short, or an array cannot be written.
Result<std::vector<FileEntry>> write_arrays(const std::filesystem::path& dir,
                                            const SequenceInfo& info);

// The pieces, and their folder if nothing else is in it. Nothing happens where there are none.
void remove_pieces(const std::filesystem::path& dir, std::uint32_t sequence);

// The grey picture or, where there is none, the level; empty if there is neither.
std::string image_array(const SequenceInfo& info, std::string_view view);

}  // namespace ensonify
