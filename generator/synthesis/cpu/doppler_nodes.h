// The spectra of Doppler echoes, from the spectra of a few nodes.
//
// The spectrum of a pulse with Doppler eta is interpolated from the spectra at a few nodes:
// S_eta = sum_q L_q(eta) S_(eta_q). All pings of a setup have the same nodes. Node 0 is at Doppler
// 0, nodes 1, 2, ... are at increasing Doppler, and nodes -1, -2, ... at the same negative values.
// Bands of equal width adjoin each other on both sides of 0. The nodes of a band are the extrema of
// a Chebyshev polynomial, ends included, so that neighboring bands share a node.
//
//   DopplerNodes  choose_doppler_nodes
//   node_doppler  the Doppler of a node
//   DopplerWeigher  weights_at   the nodes for a Doppler and their weights
//   largest_magnitude
//   NodeSpectra   the spectra at the nodes
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "acoustics/pulse.h"

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

// The same for many values.
class DopplerWeigher {
 public:
  explicit DopplerWeigher(const DopplerNodes& nodes);

  // The first node and the step to the next one.
  struct Band {
    int first_node, step;
  };
  // Writes the weights to value [degree + 1].
  Band weigh(double doppler, double* value) const;

  int degree() const { return degree_; }

 private:
  static constexpr int kMost = DopplerNodes::kMostDegree + 1;
  int degree_;
  double width_;
  std::array<double, kMost> place_{}, scale_{};  // in a band of width 1; of L_q
};

// A pulse counts as outside of the band if its spectrum is below this part of the spectrum at rest.
inline constexpr double kInaudible = 1e-9;

// The largest magnitude of a spectrum.
double largest_magnitude(const std::vector<std::complex<double>>& spectrum);

class NodeSpectra {
 public:
  NodeSpectra(DopplerPulse pulse, DopplerNodes nodes);

  const DopplerNodes& nodes() const { return nodes_; }
  // Empty if the pulse is outside of the band.
  std::vector<std::complex<double>> at(int node) const;

 private:
  DopplerPulse pulse_;
  DopplerNodes nodes_;
  double loudest_;
};

}  // namespace ensonify
