// Sequences whose pings are made and handed over without files.
//
//   StreamSource      what all sequences of a scenario share
//   open_source
//   LiveSequence      one that is ready to make pings
//   open_sequence  live_ping
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>

#include "app/pipeline.h"
#include "app/sequence_worlds.h"
#include "app/tables.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/ping.h"

namespace ensonify {

// May be used from several threads at once.
struct StreamSource {
  SequenceWorlds worlds;
  Numerics numerics;
  std::mutex mutex;    // of what follows
  SharedParts shared;  // of the one world, where sequences do not have their own
  std::optional<std::array<double, 2>> limits_db;  // of 8-bit images; absent: not asked for yet
};

// Errors: those of SequenceWorlds::open and settle_backend.
Result<std::shared_ptr<StreamSource>> open_source(const ScenarioOptions& input,
                                                  BackendChoice backend);

struct LiveSequence {
  ReadyWorld world;
  PingRange pings;  // that it has
  Pipeline pipeline;
  // What its pings need once they are made, when the world has gone.
  std::shared_ptr<const SequenceInfo> info;
  std::shared_ptr<const PipelineTables> tables;
};

// The sequence with `output`, which asks for nothing that the scenario's own selection leaves out.
// Its pings equal those that `generate` writes. Errors: those of SequenceWorlds::world,
// make_pipeline and display_limits_db. Throws DeviceFailure.
Result<std::shared_ptr<const LiveSequence>> open_sequence(StreamSource& source,
                                                          std::uint32_t sequence,
                                                          const OutputSelection& output,
                                                          const Workers& workers);

// A ping with its planes rounded as files hold them, without its scatterers. From several threads
// at once.
PingResult live_ping(const LiveSequence& sequence, std::uint32_t ping, const Workers& workers);

}  // namespace ensonify
