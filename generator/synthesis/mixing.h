// Beam mixing: how ideal sectors add up to real beams (Choi et al. 2021, Eq 16 and 17).
#pragma once

#include <vector>

#include "core/sonar.h"

namespace ensonify {

struct Mixing {
  std::vector<double> weight;  // [count], B_az at a distance of k sectors; even in k
  std::vector<double> scale;   // [count], 1 / N_j
};

// p_j = scale_j sum_i weight_|i-j| p_i. Sectors are equally spaced, so that one weight a distance
// says all. N_j = 1 (calibrated) or sqrt(sum_i weight^2) (mean_square, Eq 16).
Mixing make_mixing(const Sonar& sonar);

}  // namespace ensonify
