#include "synthesis/mixing.h"

#include <cmath>
#include <cstdlib>

#include "acoustics/pattern.h"

namespace ensonify {

Mixing make_mixing(const Sonar& sonar) {
  const int count = sonar.beam_count;
  Mixing mixing;
  mixing.weight.resize(count);
  const ReceivePattern pattern = make_receive_pattern(sonar.shading, sonar.beam_width_rad);
  for (int k = 0; k < count; ++k) {
    mixing.weight[k] = receive_pattern(pattern, k * sonar.beam_spacing_rad);
  }
  mixing.scale.assign(count, 1.0);
  if (sonar.normalization == Normalization::calibrated) return mixing;
  for (int j = 0; j < count; ++j) {
    double energy = 0;
    for (int i = 0; i < count; ++i) {
      const double w = mixing.weight[std::abs(i - j)];
      energy += w * w;
    }
    mixing.scale[j] = 1.0 / std::sqrt(energy);
  }
  return mixing;
}

}  // namespace ensonify
