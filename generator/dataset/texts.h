// What the files of a data set would say of a ping that has none.
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
