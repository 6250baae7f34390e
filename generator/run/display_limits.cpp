#include "run/display_limits.h"

#include <memory>
#include <utility>

#include "labels/display.h"
#include "ping/sequence_info.h"
#include "ping/session.h"

namespace ensonify {

WorldsFrom worlds_from_first(const SequenceWorlds& worlds) {
  return {[&](std::uint32_t sequence) { return worlds.world(sequence); }, worlds.vary(),
          worlds.first_sequence()};
}

Status for_probed_sequences(const WorldsFrom& worlds,
                            const std::function<Status(std::uint32_t, const ReadyWorld&)>& use) {
  int made = 0;
  const std::uint32_t end = worlds.first + (worlds.vary ? kProbesTried : 1);
  for (std::uint32_t sequence = worlds.first; sequence < end && made < kProbes; ++sequence) {
    const Result<ReadyWorld> ready = worlds.world(sequence);
    const Status used = ready ? use(sequence, *ready) : Status(ready.error());
    if (used) {
      ++made;
    } else if (const ErrorKind kind = used.error().kind;
               kind != ErrorKind::usage && kind != ErrorKind::final_usage) {
      return used;
    }
  }
  return {};
}

Result<EchoLevels> probe_levels(const ReadyWorld& world, std::uint32_t sequence,
                                const Numerics& numerics, const Workers& workers,
                                SharedParts& shared, bool keeps_ping_zero) {
  const auto& [session, tracer] = world;
  if (!shared.tables) shared.tables = pipeline_tables(*session, numerics);
  SequenceInfo info = sequence_info(*session, sequence, 0, 1);
  const bool speckle_moves = info.speckle != SpeckleMode::surface;
  const PingSetup setup = ping_setup(*session, *tracer, std::move(info), shared.tables);
  Result<Calibrated> made = calibrate(setup, {setup.display != nullptr, keeps_ping_zero}, workers);
  if (!made) return made.error();
  if (speckle_moves) shared.noise_power_pa2 = made->noise_power_pa2;
  if (keeps_ping_zero) shared.ping_zero = std::make_shared<PingStart>(std::move(made->ping_zero));
  return std::move(made->echoes);
}

std::optional<std::array<double, 2>> given_limits_db(const OutputSpec& output) {
  return output.selection.png ? output.png_db : Display{}.limits_db;
}

Result<std::array<double, 2>> display_limits_db(const OutputSpec& output, const WorldsFrom& worlds,
                                                const Numerics& numerics, const Workers& workers,
                                                SharedParts* first, bool keeps_ping_zero) {
  if (const auto given_db = given_limits_db(output)) return *given_db;
  EchoLevels levels;
  const auto use = [&](std::uint32_t sequence, const ReadyWorld& ready) -> Status {
    const bool known = sequence == worlds.first && first != nullptr;
    SharedParts own;
    const Result<EchoLevels> more = probe_levels(ready, sequence, numerics, workers,
                                                 known ? *first : own, known && keeps_ping_zero);
    if (!more) return more.error();
    levels.add(*more);
    return {};
  };
  if (Status probed = for_probed_sequences(worlds, use); !probed) return probed.error();
  return default_limits_db(std::move(levels));
}

}  // namespace ensonify
