// A scenario made ready to run: everything that can be wrong with the input has been looked at,
// and nothing has been written.
//
//   Session          prepare_session
//   sequence_info    what one sequence's files say of it
//   pick_split       train, val or test
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/ping.h"
#include "scenario/scenario.h"
#include "world/path.h"
#include "world/world.h"

namespace ensonify {

struct Session {
  Scenario scenario;
  Sonar sonar;
  Water water;
  Record record;
  double noise_power_pa2 = 0;  // per sample; 0: none
  Pose mount;                  // sonar on the body
  World world;
  Path path;                         // of the body
  std::vector<double> ping_times_s;  // of all pings, whatever range is run
};

// Loads meshes and paths. Errors (usage): those of build_world, load_path and ping_times.
Result<Session> prepare_session(Scenario scenario);

// Without the PNG limits, which need the clean image of ping 0.
SequenceInfo sequence_info(const Session& session, std::uint32_t sequence, std::uint32_t first_ping,
                           std::uint32_t last_ping);

// A draw keyed by seed and sequence: the same whatever else is run.
std::string pick_split(const SplitsSpec& splits, std::uint64_t seed, std::uint32_t sequence);

// Where the sonar is at a ping.
Pose sonar_pose(const Session& session, std::uint32_t ping);

}  // namespace ensonify
