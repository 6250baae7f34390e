// Pings made and written, sequence by sequence.
#pragma once

#include <span>

#include "app/commands.h"
#include "app/sequence_worlds.h"
#include "core/parallel.h"

namespace ensonify {

// Makes the pings of these sequences that are missing from the data set's folder and finishes each
// sequence. Several sequences are under way at once where one has too few pings to fill the
// threads. Error kinds: usage (a world cannot be built), io, interrupted; what is finished is kept.
Status make_sequences(const GenerateOptions& options, const Numerics& numerics,
                      const SequenceWorlds& worlds,
                      std::span<const SequenceInfo> sequences, const Workers& workers);

}  // namespace ensonify
