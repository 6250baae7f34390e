// Whether a run fits into the memory that is there, before anything large is made.
//
//   room_for_scenario   before its world is built
//   room_for_world      before its tracer is made
//   threads_that_fit    before its first ping
//   numerics_that_fit   on a device
//
// Each of the first three takes what counts alone give as the least, and refuses only what needs
// more than that with one thread. An error (device) names the key that costs most and its largest
// value that fits.
#pragma once

#include <functional>
#include <string_view>

#include "core/error.h"
#include "ping/session.h"
#include "ping/tables.h"
#include "trace/tracer.h"

namespace ensonify {

// From rays, samples, images, terrain and the files of a scene, without scatterers. No error if the
// scenario has other errors, which are found when it is prepared.
Status room_for_scenario(const Scenario& scenario);

// The same with the meshes of the world and the distance field.
Status room_for_world(const Session& session);

// The number of threads, or fewer if that many need more memory than is there, which `warn`
// reports. With the backend's tables, which are kept in `numerics`, and scatterers by probe_echoes
// unless an upper bound fits. The error is the same.
Result<int> threads_that_fit(const Session& session, const Tracer& tracer, const Numerics& numerics,
                             int threads, const std::function<void(std::string_view)>& warn);

// `numerics`, or those of the processor, which `warn` reports, if a device that was chosen
// automatically cannot make the pings of the session: it has no memory for one, or
// synthesis.tolerance asks for double precision. Makes the backend's tables, which are kept in
// `numerics`. Error (device): the same for a device that was asked for.
Result<Numerics> numerics_that_fit(const Session& session, const Tracer& tracer,
                                   const Numerics& numerics,
                                   const std::function<void(std::string_view)>& warn);

}  // namespace ensonify
