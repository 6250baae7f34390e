// Echoes that come back shifted, on top of any PingSynthesis.
#pragma once

#include <complex>
#include <functional>
#include <memory>
#include <vector>

#include "synthesis/cpu/ping_synthesis.h"

namespace ensonify {

// Pulses under this part of the unshifted one's amplitude have left the band.
inline constexpr double kInaudible = 1e-9;

// The largest magnitude of a spectrum.
double largest_magnitude(const std::vector<std::complex<double>>& spectrum);

using MakeSynthesis = std::function<std::unique_ptr<PingSynthesis>(const SynthesisTables&)>;

// Adds up what `make` makes of a few spectra (doppler_nodes.h), each with the gains of all
// scatterers weighted by their shifts. Nodes are made when a scatterer first needs them, the same
// for any ping, so that the result is linear in the scatterers. Pings without shifts are those of
// make(tables), but for a tolerance above 3e-5, which is lowered to it. None where no nodes hold
// the tolerance.
std::unique_ptr<PingSynthesis> make_doppler_synthesis(const SynthesisTables& tables,
                                                      MakeSynthesis make);

}  // namespace ensonify
