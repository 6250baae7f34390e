// Sequences whose pings are made and returned without files.
//
//   StreamSource      common data of all sequences of a scenario
//   open_source
//   LiveSequence      a sequence that is ready to make pings
//   open_sequence  live_ping
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "core/ping.h"
#include "ping/pipeline.h"
#include "ping/tables.h"
#include "run/sequence_worlds.h"

namespace ensonify {

// May be used from several threads at once.
struct StreamSource {
  SequenceWorlds worlds;
  Numerics numerics;
  std::mutex mutex;                                // protects the members below
  SharedParts shared;                              // of the only world, if sequences share one
  std::optional<std::array<double, 2>> limits_db;  // of 8-bit images; absent: not computed yet
  std::vector<std::string> warnings = {};          // of the start: why there is no device
};

// Errors: those of SequenceWorlds::open, settle_backend and numerics_that_fit.
Result<std::shared_ptr<StreamSource>> open_source(const ScenarioOptions& input,
                                                  BackendChoice backend);

struct LiveSequence {
  ReadyWorld world;
  PingRange pings;  // the pings that it has
  Pipeline pipeline;
  // Data for finished pings that is needed after the world is freed.
  std::shared_ptr<const SequenceInfo> info;
  std::shared_ptr<const PipelineTables> tables;
};

// Opens the sequence with `output`, which must not select more than the scenario does. Its pings
// equal those that `generate` writes. Errors: those of SequenceWorlds::world, make_pipeline and
// display_limits_db. Throws DeviceFailure.
Result<std::shared_ptr<const LiveSequence>> open_sequence(StreamSource& source,
                                                          std::uint32_t sequence,
                                                          const OutputSelection& output,
                                                          const Workers& workers);

// Makes a ping with its planes rounded as in files, without its scatterers. May be called from
// several threads at once.
PingResult live_ping(const LiveSequence& sequence, std::uint32_t ping, const Workers& workers);

}  // namespace ensonify
