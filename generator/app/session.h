// A scenario prepared to run: all input has been checked, and nothing has been written.
//
//   Session          prepare_session  prepare_in_world  give_back_import
//                    prepare_without_world
//   sequence_info    the description of one sequence for its files
//   pick_split       train, val or test
//   undersampled_warnings  whether a scene has enough scatterers for speckle
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/ringing.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/ping.h"
#include "scenario/scenario.h"
#include "trace/adaptive.h"
#include "trace/mirrors.h"
#include "trace/surface_points.h"
#include "world/path.h"
#include "world/world.h"

namespace ensonify {

struct Session {
  Scenario scenario;
  Sonar sonar;
  Water water;
  Record record;
  ResolutionCell cell;  // only from prepare_session
  Pose mount;           // sonar on the body
  World world;
  BouncePlan bounces;                              // without paths if there is no multipath
  Path path;                                       // of the body
  std::vector<double> ping_times_s;                // of all pings, whatever range is run
  std::optional<SurfaceTiles> surface_tiles = {};  // with speckle: surface
  std::optional<Placement> placement = {};         // only from drawn_session
};

// Loads meshes, tables and paths; `sequence` keys the random values of the world. Errors (usage):
// those of load_pulse_table, build_world, load_path and ping_times, all together; of
// make_bounce_plan; a sonar that leaves the water between surface and bottom; more scatterers on
// surfaces than kMostLeaves in a ping. Objects that the world leaves out are removed from the
// scenario as well. `shared` holds what the worlds of many sequences have in common, and may be
// null.
struct SharedWorlds {
  MeshLibrary meshes;
  RingingLibrary ringing;
};
Result<Session> prepare_session(Scenario scenario, std::uint32_t sequence,
                                SharedWorlds* shared = nullptr);

// The same with the world, or error, that build_world made from a scenario that is equal in
// everything that worlds depend on (world_key, sweep_parts.h).
Result<Session> prepare_in_world(Scenario scenario, std::uint32_t sequence, Result<World> world);

// Returns the memory that importing a large mesh needs temporarily, several times that of the mesh.
void give_back_import(const World& world);

// prepare_session without building anything: the world has only ids, names and classes, and there
// is no cell.
Result<Session> prepare_without_world(Scenario scenario, std::uint32_t sequence);

// The result lacks limits of 8-bit images that the scenario does not state (display_limits.h), and
// the noise power of an snr_db, which needs the expected image of ping 0.
SequenceInfo sequence_info(const Session& session, std::uint32_t sequence, std::uint32_t first_ping,
                           std::uint32_t last_ping);

// The choice depends only on seed and sequence, and not on the other sequences of the run.
std::string pick_split(const SplitsSpec& splits, std::uint64_t seed, std::uint32_t sequence);

// The poses of the sonar and of each of World::objects at a ping.
Pose sonar_pose(const Session& session, std::uint32_t ping);
std::vector<Pose> object_poses(const Session& session, std::uint32_t ping);

// With fewer scatterers in a resolution cell, speckle is not fully developed.
inline constexpr double kFewScatterers = 10;

// Warnings if more than a twentieth of the range covered by the rays of the first ping has fewer
// than kFewScatterers per cell. Multipath echoes, which adaptive refinement and scatterers fixed on
// surfaces do not affect, are judged by the rays of the fan. `tracer` is that of the session's
// world.
std::vector<std::string> undersampled_warnings(const Session& session, const Tracer& tracer,
                                               const Workers& workers);

}  // namespace ensonify
