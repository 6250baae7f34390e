#include "dataset/texts.h"

#include "dataset/manifest_json.h"
#include "dataset/ping_record.h"

namespace ensonify {

std::string sequence_text(const SequenceInfo& info) { return sequence_head(info, {}, 0).dump(); }

std::string annotations_text(const SequenceInfo& info, const PingResult& result) {
  return record_of(info, result, {}).annotations;
}

}  // namespace ensonify
