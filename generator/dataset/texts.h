// Texts of a data set's files for a ping without files.
//
//   sequence_text     sequence.json without its list of files
//   annotations_text  the ping's line of annotations.jsonl
#pragma once

#include <string>

#include "core/ping.h"

namespace ensonify {

std::string sequence_text(const SequenceInfo& info);

// Needs a result that fits `info`.
std::string annotations_text(const SequenceInfo& info, const PingResult& result);

}  // namespace ensonify
