// sequence.json: the sequence as drawn, and what a reader needs to work its time series out again
// from scatterers/*.npy. Private to dataset/.
//
//   sequence_head     all but the list of files
//   files_opening  file_line  files_closing   the list, one line an entry, for writing it piecewise
//   sequence_is_whole                         found on disk, with every file it lists
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/ping.h"
#include "dataset/files.h"
#include "dataset/json.h"

namespace ensonify {

// `each_ping`: templates of a ping's files (layout.h); `bytes`: of all files together.
Json sequence_head(const SequenceInfo& info, const std::vector<std::string>& each_ping,
                   std::uint64_t bytes);

// The head as text, left open behind `"files": [`.
std::string files_opening(const Json& head);
std::string file_line(const FileEntry& entry, bool first);
std::string files_closing();

// Whether the sequence has a sequence.json and every file in it is there with its size.
bool sequence_is_whole(const std::filesystem::path& dir, std::uint32_t sequence);

}  // namespace ensonify
