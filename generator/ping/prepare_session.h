// From a checked scenario to a session: everything that can be wrong with a sequence is found here.
//
//   prepare_session  prepare_in_world  give_back_import
//   prepare_without_world
//   kMostRedraws  DrawSteps  drawn_session   samples a sequence that can be built
//   is_of_sequence  as_usage   errors of one sequence
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "core/error.h"
#include "core/random.h"
#include "ping/ringing.h"
#include "ping/session.h"
#include "scenario/scenario.h"

namespace ensonify {

// Loads meshes, tables and paths; `sequence` keys the random values of the world. Errors (usage):
// those of load_pulse_table, build_world, load_path and ping_times, all together; of
// make_bounce_plan; of check_mount; a sonar that leaves the water between surface and bottom; more
// scatterers on surfaces than kMostLeaves in a ping; with output.statistics, speckle that lasts,
// and a sonar or an object that is not at rest. Objects that the world leaves out are removed from
// the scenario as well. `shared` holds what the worlds of many sequences have in common, and may be
// null.
struct SharedWorlds {
  MeshLibrary meshes;
  RingingLibrary ringing;
};
Result<Session> prepare_session(Scenario scenario, std::uint32_t sequence,
                                SharedWorlds* shared = nullptr);

// The same with the world, or error, that build_world made from a scenario that is equal in
// everything that worlds depend on (world_key, sweep_parts.h). `tiles`, unless null, are those of
// another session of this world and this sequence that differs in the instrument of its rig alone.
Result<Session> prepare_in_world(Scenario scenario, std::uint32_t sequence, Result<World> world,
                                 std::shared_ptr<const SurfaceTiles> tiles = {},
                                 RingingLibrary* ringing = nullptr);

// Returns the memory that importing a large mesh needs temporarily, several times that of the mesh.
void give_back_import(const World& world);

// prepare_session without building anything: the world has only ids, names and classes, and there
// is no cell.
Result<Session> prepare_without_world(Scenario scenario, std::uint32_t sequence);

// Objects that are placed at random may find no room, and then the whole sequence is sampled again.
inline constexpr std::uint32_t kMostRedraws = 100;

struct DrawSteps {
  std::function<Result<Scenario>(SequenceDraw)> scenario;
  // prepare_session, or a replacement for it.
  std::function<Result<Session>(Scenario, std::uint32_t sequence)> session;
};

// The session of the first sample for which both steps succeed, with its `placement`. Errors: those
// of the steps; ErrorKind::redraw becomes incomplete after kMostRedraws further samples.
Result<Session> drawn_session(const DrawSteps& steps, std::uint32_t sequence);

// Whether the error comes from the samples of its sequence, so that others may well be possible.
inline bool is_of_sequence(const Error& error) {
  return error.kind == ErrorKind::incomplete || error.kind == ErrorKind::final_usage;
}

// The error of a sequence as that of the scenario that was asked for.
inline Error as_usage(const Error& error) {
  return {error.kind == ErrorKind::incomplete ? ErrorKind::usage : error.kind, error.message};
}

}  // namespace ensonify
