// Estimates the bytes of a data set from pings that are encoded but not written.
//
//   PingBytes  ping_bytes     what a ping adds
//   sequence_bytes            what a sequence takes apart from its pings
#pragma once

#include <cstdint>

#include "core/error.h"
#include "core/ping.h"
#include "dataset/write_ping.h"

namespace ensonify {

struct PingBytes {
  std::uint64_t files = 0;           // its own, and its part of arrays
  std::uint64_t piece = 0;           // the part of arrays, until the sequence is finished
  std::uint64_t sequence_lines = 0;  // its lines in the tables and the manifest of the sequence
  std::uint64_t dataset_lines = 0;   // ... and in index.csv, splits and coco.json
  std::uint64_t record = 0;          // until the data set is finished
};

// Error (bug): `encoded` is not of encode_ping.
Result<PingBytes> ping_bytes(const SequenceInfo& info, const EncodedPing& encoded);

// The bytes of a sequence without its distance field. `encoded` is one of its pings.
std::uint64_t sequence_bytes(const SequenceInfo& info, const EncodedPing& encoded);

}  // namespace ensonify
