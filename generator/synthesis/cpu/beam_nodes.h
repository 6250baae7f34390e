// Beam mixing with few sums: the weights are a smooth function of the beam, so that they hold in
// much fewer nodes across the fan.
//
//   W = P K P^T: P spreads each beam over a few neighbouring nodes, K mixes the nodes.
#pragma once

#include <vector>

namespace ensonify {

struct BeamNodes {
  int beams = 0;
  int nodes = 0;               // even, placed symmetrically about the fan's middle
  int width = 0;               // nodes that a beam reaches
  double error = 0;            // relative L2 of the worst of the sampled columns of W
  std::vector<int> first;      // [beams]
  std::vector<double> weight;  // [beams][width]: P
  std::vector<double> matrix;  // [nodes][nodes]: K, symmetric and persymmetric
};

// `weight` is W's by distance. The cheapest with an error of at most `tolerance`; nodes = beams (or
// one more) with K = W where nothing less will do. `row_cost` is that of transforming one node's
// record, in multiplications per sample.
BeamNodes choose_beam_nodes(const std::vector<double>& weight, double tolerance, double row_cost);

}  // namespace ensonify
