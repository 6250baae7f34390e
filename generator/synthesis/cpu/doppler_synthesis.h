// Doppler echoes, on top of any PingSynthesis.
//
//   make_doppler_synthesis
#pragma once

#include <functional>
#include <memory>

#include "synthesis/cpu/ping_synthesis.h"

namespace ensonify {

using MakeSynthesis = std::function<std::unique_ptr<PingSynthesis>(const SynthesisTables&)>;

// Leaves echoes with Doppler to run_shifted of make(tables). Where this cannot synthesize them,
// adds up the results of `make` for the spectra of a few nodes. At each node, the gains of all
// scatterers are weighted by their Doppler. A node is made when a scatterer first needs it. Nodes
// are the same for all pings, so that the result is linear in the scatterers. Pings without Doppler
// are those of make(tables), except that a tolerance above 3e-5 is lowered to this value. Null if
// no nodes hold the tolerance.
std::unique_ptr<PingSynthesis> make_doppler_synthesis(const SynthesisTables& tables,
                                                      MakeSynthesis make);

}  // namespace ensonify
