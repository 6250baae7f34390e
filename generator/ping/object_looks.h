// How the sonar sees each object. `check` prints this before anything is made.
//
//   ObjectLook  looks_at  look_at_objects   at ping 0 of one sequence
//   look_lines                    as a table
//   SeenObjects  note_seen  unseen_warnings   objects that are never in view
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "core/ping.h"
#include "ping/session.h"
#include "ping/tables.h"
#include "trace/tracer.h"

namespace ensonify {

struct ObjectLook {
  std::string name;
  std::optional<Vec3> size_m;                              // along its own axes; absent: infinite
  double range_m = 0, azimuth_rad = 0, elevation_rad = 0;  // of its center, in the sonar's frame
  std::optional<double> share_in_fan;    // of its surface (trace/truncation.h); absent: infinite
  std::int64_t pixels = 0;               // of the polar image, in which it is the strongest
  std::optional<double> over_ground_db;  // mean expected power, against the ground around it
                                         // (labels/annotations.h)
  std::optional<double> over_noise_db;   // ... against the noise
};

// In the order of the objects. `ping_zero` has its polar image.
std::vector<ObjectLook> looks_at(const Session& session, const PingResult& ping_zero,
                                 double noise_power_pa2);

// The same of a ping that is made for it. Errors: those of make_pipeline.
Result<std::vector<ObjectLook>> look_at_objects(const Session& session, const Tracer& tracer,
                                                std::uint32_t sequence, const Numerics& numerics,
                                                const Workers& workers);

// One line for the header and each object (at most the first 24), without line ends.
std::vector<std::string> look_lines(const std::vector<ObjectLook>& looks);

// Objects that were seen in any examined sequence. If the scenario samples values, single objects
// may be out of view, so classes are counted instead.
struct SeenObjects {
  std::map<std::string, bool> is_seen;       // by name, or by class if anything is sampled
  std::map<std::string, std::string> where;  // for one that is not seen: its place at ping 0
  std::vector<std::string> empty_pings;      // "ping 0 of sequence 3"
};

// Adds the objects that rays of the fan hit at the first, middle and last ping. Point targets and
// volumes are not examined.
void note_seen(const Session& session, const Tracer& tracer, std::uint32_t sequence,
               const std::vector<ObjectLook>& looks, const Workers& workers, SeenObjects& seen);
std::vector<std::string> unseen_warnings(const SeenObjects& seen, const Scenario& scenario);

}  // namespace ensonify
