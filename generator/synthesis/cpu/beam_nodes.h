// Beam mixing in few sums: nodes across the fan represent the beam cells, because the weights of
// mixing are a smooth function of the azimuth.
//
//   BeamNodes               the nodes, and the matrices that lead from cells to beams
//   choose_beam_nodes       of equal beams: W = P K P^T, where P spreads each beam over a few
//                           neighboring nodes and K mixes the nodes
//   choose_unequal_nodes    of unequal beams: W = R P^T, where P spreads each cell over a few
//                           neighboring nodes, and R makes each beam of all nodes
#pragma once

#include <vector>

namespace ensonify {

struct BeamNodes {
  int beams = 0;           // and beam cells
  int nodes = 0;           // an even number
  int width = 0;           // nodes that a beam cell reaches
  double error = 0;        // relative L2 error, the worst of some columns of W (unequal: of all)
  std::vector<int> first;  // [beams]
  std::vector<double> weight;  // [beams][width]: P
  // Of equal beams, whose nodes are symmetric about the fan's middle: [nodes][nodes], K, symmetric
  // and persymmetric. Of unequal beams: [beams][nodes], R.
  std::vector<double> matrix;
  bool is_equal = true;
};

// The nodes of least cost with an error of at most `tolerance`. If fewer nodes do not suffice,
// nodes = beams (or one more) and K = W. `weight` contains W by distance. `row_cost` is the cost of
// transforming one node's record, in multiplications per sample.
BeamNodes choose_beam_nodes(const std::vector<double>& weight, double tolerance, double row_cost);

// The same for any weights W, `matrix` [beams][cells], of cells with the given middles, which
// increase. Every column of W holds the tolerance, relative to its own norm. If fewer nodes do not
// suffice, each cell has its own and R = W.
BeamNodes choose_unequal_nodes(const std::vector<double>& matrix,
                               const std::vector<double>& middle_rad, double tolerance,
                               double row_cost);

}  // namespace ensonify
