// Doppler echoes, on top of any PingSynthesis.
//
// Spectra of shifted pulses are sums of a few: S_eta = sum_q L_q(eta) S_(eta_q). Nodes lie at the
// same shifts for every ping of a setup: node 0 at 0, nodes 1, 2, ... at rising shifts, -1, -2, ...
// mirrored. Bands of equal width follow each other from 0 on either side; each has the extrema of a
// Chebyshev polynomial, ends included, so that neighbours share a node.
//
//   DopplerNodes  choose_doppler_nodes
//   node_doppler  where a node is
//   weights_at    the nodes of a shift and what it gives to each
//   largest_magnitude  make_doppler_synthesis
#pragma once

#include <array>
#include <complex>
#include <functional>
#include <memory>
#include <vector>

#include "acoustics/pulse.h"
#include "synthesis/cpu/ping_synthesis.h"

namespace ensonify {

struct DopplerNodes {
  static constexpr int kMostDegree = 24;
  int degree = 0;    // nodes of a band, but for one; 0: no nodes hold the tolerance
  double width = 0;  // of a band, in shift
};

// Those of least cost where the shifts of a ping spread over 1e-3. Interpolated pulses err by at
// most 0.3 `tolerance` of the unshifted pulse's norm and, in all that is further than x from the
// pulse's middle, by 10 `tolerance` of what the pulse has there, down to a tail of 1e-6. degree 0
// where that takes 1000 nodes: pulses of a hundred milliseconds, and tables, whose corners no
// polynomial follows.
DopplerNodes choose_doppler_nodes(const DopplerPulse& pulse, double tolerance);

double node_doppler(const DopplerNodes& nodes, int node);

// Nodes first_node, first_node + step, ... have value[0 .. degree], step = +-1. At a node's own
// shift the others have 0.
struct DopplerWeights {
  int first_node = 0, step = 1;
  std::array<double, DopplerNodes::kMostDegree + 1> value{};
};
DopplerWeights weights_at(const DopplerNodes& nodes, double doppler);

// Pulses under this part of the unshifted one's amplitude have left the band.
inline constexpr double kInaudible = 1e-9;

// The largest magnitude of a spectrum.
double largest_magnitude(const std::vector<std::complex<double>>& spectrum);

using MakeSynthesis = std::function<std::unique_ptr<PingSynthesis>(const SynthesisTables&)>;

// Adds up what `make` makes of a few spectra, those of the nodes, each with the gains of all
// scatterers weighted by their shifts. Nodes are made when a scatterer first needs them, the same
// for any ping, so that the result is linear in the scatterers. Pings without shifts are those of
// make(tables), but for a tolerance above 3e-5, which is lowered to it. None where no nodes hold
// the tolerance.
std::unique_ptr<PingSynthesis> make_doppler_synthesis(const SynthesisTables& tables,
                                                      MakeSynthesis make);

}  // namespace ensonify
