// A scenario made ready to run: everything that can be wrong with the input has been looked at,
// and nothing has been written.
//
//   Session          prepare_session  prepare_in_world  give_back_import
//                    prepare_without_world
//   sequence_info    what one sequence's files say of it
//   pick_split       train, val or test
//   reach_of  sdf_size_of
//   undersampled_warnings  whether a scene has scatterers enough for speckle
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "core/ping.h"
#include "scenario/scenario.h"
#include "trace/adaptive.h"
#include "trace/mirrors.h"
#include "trace/surface_points.h"
#include "world/path.h"
#include "world/scene_sdf.h"
#include "world/world.h"

namespace ensonify {

struct Session {
  Scenario scenario;
  Sonar sonar;
  Water water;
  Record record;
  ResolutionCell cell;  // of prepare_session alone
  Pose mount;           // sonar on the body
  World world;
  BouncePlan bounces;                              // without paths where there is no multipath
  Path path;                                       // of the body
  std::vector<double> ping_times_s;                // of all pings, whatever range is run
  std::optional<SurfaceTiles> surface_tiles = {};  // of speckle: surface
  std::optional<Placement> placement = {};         // of drawn_session alone
};

// Loads meshes, tables and paths; `sequence` keys what the world draws. Errors (usage): those of
// load_pulse_table, build_world, load_path and ping_times, all at once; of make_bounce_plan, of a
// sonar that leaves the water between surface and bottom, and of more scatterers on surfaces than
// kMostLeaves in a ping. Of objects that the world leaves out the scenario has no more either.
// `library`: as for build_world.
Result<Session> prepare_session(Scenario scenario, std::uint32_t sequence,
                                MeshLibrary* library = nullptr);

// The same with a world, or the error of one, that build_world made of an equal scenario; equal but
// for what worlds do not depend on (world_key, sweep_parts.h).
Result<Session> prepare_in_world(Scenario scenario, std::uint32_t sequence, Result<World> world);

// Importing a large mesh takes several times what is kept of it; nothing else gives that back.
void give_back_import(const World& world);

// prepare_session without building anything: the world holds only ids, names and classes, and there
// is no cell.
Result<Session> prepare_without_world(Scenario scenario, std::uint32_t sequence);

// Without limits of 8-bit images that the scenario does not give (display_limits.h), and without
// the noise power of an snr_db, which needs the clean image of ping 0.
SequenceInfo sequence_info(const Session& session, std::uint32_t sequence, std::uint32_t first_ping,
                           std::uint32_t last_ping);

// A draw keyed by seed and sequence: the same whatever else is run.
std::string pick_split(const SplitsSpec& splits, std::uint64_t seed, std::uint32_t sequence);

// The box that the sonar hears, from all places of the pings [first, last).
SdfRegion reach_of(const Session& session, std::uint32_t first_ping, std::uint32_t last_ping);

// What output.sdf takes of one sequence; nothing where it is not asked for.
SdfSize sdf_size_of(const Session& session);

// Where the sonar is at a ping, and each of World::objects.
Pose sonar_pose(const Session& session, std::uint32_t ping);
std::vector<Pose> object_poses(const Session& session, std::uint32_t ping);

// Fewer of them in a resolution cell do not make developed speckle.
inline constexpr double kFewScatterers = 10;

// What to tell the user where more than a twentieth of the range that the rays of the first ping
// pass over has fewer than kFewScatterers a cell; bounced echoes, which no rays by need reach and
// no scatterers fixed on surfaces make, are judged by the rays of the fan. `tracer` is of the
// session's world.
std::vector<std::string> undersampled_warnings(const Session& session, const Tracer& tracer,
                                               const Workers& workers);

}  // namespace ensonify
