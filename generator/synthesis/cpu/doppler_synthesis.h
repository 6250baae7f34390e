// Doppler echoes, on top of any PingSynthesis.
//
// The spectrum of a pulse with Doppler eta is interpolated from the spectra at a few nodes:
// S_eta = sum_q L_q(eta) S_(eta_q). All pings of a setup have the same nodes. Node 0 is at Doppler
// 0, nodes 1, 2, ... are at increasing Doppler, and nodes -1, -2, ... at the same negative values.
// Bands of equal width adjoin each other on both sides of 0. The nodes of a band are the extrema of
// a Chebyshev polynomial, ends included, so that neighboring bands share a node.
//
//   DopplerNodes  choose_doppler_nodes
//   node_doppler  the Doppler of a node
//   weights_at    the nodes for a Doppler and their weights
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
  int degree = 0;    // a band has degree + 1 nodes; 0: no nodes hold the tolerance
  double width = 0;  // of a band, in Doppler
};

// The nodes of least cost for pings whose Doppler has a span of 1e-3. The error of an interpolated
// pulse is at most 0.3 `tolerance` relative to the norm of the pulse at rest. At a distance of more
// than x from the pulse's middle, for any x, it is at most 10 `tolerance` relative to the norm of
// the pulse there, down to a tail of 1e-6. degree = 0 if this takes 1000 nodes, as for pulses of a
// hundred milliseconds, and for pulses from tables, whose corners polynomials do not represent.
DopplerNodes choose_doppler_nodes(const DopplerPulse& pulse, double tolerance);

double node_doppler(const DopplerNodes& nodes, int node);

// Nodes first_node, first_node + step, ... have the weights value[0 .. degree], with step = +-1. At
// the Doppler of a node, all other nodes have the weight 0.
struct DopplerWeights {
  int first_node = 0, step = 1;
  std::array<double, DopplerNodes::kMostDegree + 1> value{};
};
DopplerWeights weights_at(const DopplerNodes& nodes, double doppler);

// A pulse counts as outside of the band if its spectrum is below this part of the spectrum at rest.
inline constexpr double kInaudible = 1e-9;

// The largest magnitude of a spectrum.
double largest_magnitude(const std::vector<std::complex<double>>& spectrum);

using MakeSynthesis = std::function<std::unique_ptr<PingSynthesis>(const SynthesisTables&)>;

// Adds up the results of `make` for the spectra of a few nodes. At each node, the gains of all
// scatterers are weighted by their Doppler. A node is made when a scatterer first needs it. Nodes
// are the same for all pings, so that the result is linear in the scatterers. Pings without Doppler
// are those of make(tables), except that a tolerance above 3e-5 is lowered to this value. Null if
// no nodes hold the tolerance.
std::unique_ptr<PingSynthesis> make_doppler_synthesis(const SynthesisTables& tables,
                                                      MakeSynthesis make);

}  // namespace ensonify
