#include "run/display_limits.h"

#include <memory>
#include <utility>
#include <vector>

#include "labels/display.h"
#include "ping/sequence_info.h"
#include "ping/session.h"

namespace ensonify {
namespace {

// Ping 0 of a sequence.
Result<Calibrated> probe(const ReadyWorld& world, std::uint32_t sequence, const Numerics& numerics,
                         const Workers& workers, SharedParts& shared, bool keeps_ping_zero) {
  const auto& [session, tracer] = world;
  if (!shared.tables) shared.tables = pipeline_tables(*session, numerics);
  SequenceInfo info = sequence_info(*session, sequence, 0, 1);
  const bool speckle_moves = info.speckle != SpeckleMode::surface;
  Result<Calibrated> made = calibrate(ping_setup(*session, *tracer, std::move(info), shared.tables),
                                      {true, keeps_ping_zero}, workers);
  if (made && speckle_moves) shared.noise_power_pa2 = made->noise_power_pa2;
  return made;
}

}  // namespace

Result<std::array<double, 2>> display_limits_db(
    const std::function<Result<ReadyWorld>(std::uint32_t sequence)>& world, bool vary,
    const Numerics& numerics, const Workers& workers, SharedParts* first, bool keeps_ping_zero) {
  EchoLevels levels;
  int made = 0;
  for (std::uint32_t sequence = 0; sequence < (vary ? kDisplayProbesTried : 1); ++sequence) {
    if (made == kDisplayProbes) break;
    const Result<ReadyWorld> ready = world(sequence);
    if (!ready && ready.error().kind == ErrorKind::usage) continue;
    if (!ready && ready.error().kind == ErrorKind::final_usage) {
      return of_sequence(sequence, ready.error());
    }
    if (!ready) return ready.error();
    const OutputSpec& output = ready->session->scenario.output;
    if (!output.selection.png) break;
    if (output.png_db) return *output.png_db;
    const bool known = sequence == 0 && first != nullptr;
    SharedParts own;
    Result<Calibrated> probed =
        probe(*ready, sequence, numerics, workers, known ? *first : own, known && keeps_ping_zero);
    if (!probed && probed.error().kind == ErrorKind::usage) continue;
    if (!probed) return probed.error();
    ++made;
    levels.add(probed->echoes);
    if (known && keeps_ping_zero) {
      first->ping_zero = std::make_shared<PingStart>(std::move(probed->ping_zero));
    }
  }
  return default_limits_db(std::move(levels));
}

}  // namespace ensonify
