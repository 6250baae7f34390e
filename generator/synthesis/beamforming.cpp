#include "synthesis/beamforming.h"

#include <cmath>

#include "acoustics/pattern.h"
#include "core/error.h"

namespace ensonify {

static Mixing unscaled_mixing(const Sonar& sonar) {
  const int count = sonar.beam_count;
  Mixing mixing;
  mixing.scale.assign(count, 1.0);
  if (has_equal_beams(sonar)) {
    const ShadedLine pattern = make_shaded_line(sonar.shading, sonar.beam_width_rad);
    mixing.weight.resize(count);
    for (int k = 0; k < count; ++k) {
      mixing.weight[k] = shaded_pattern(pattern, k * sonar.beam_spacing_rad);
    }
    return mixing;
  }
  for (int i = 0; i < count; ++i) mixing.middle_rad.push_back(cell_middle_rad(sonar, i));
  mixing.matrix.reserve(std::size_t(count) * std::size_t(count));
  for (int j = 0; j < count; ++j) {
    const ShadedLine pattern = make_shaded_line(sonar.shading, width_of_beam_rad(sonar, j));
    const double azimuth = beam_azimuth_rad(sonar, j);
    for (int i = 0; i < count; ++i) {
      mixing.matrix.push_back(shaded_pattern(pattern, mixing.middle_rad[i] - azimuth));
    }
  }
  return mixing;
}

Mixing make_mixing(const Sonar& sonar) {
  Mixing mixing = unscaled_mixing(sonar);
  if (sonar.normalization == Normalization::calibrated) return mixing;
  for (int j = 0; j < mixing.beams(); ++j) {
    double energy = 0;
    for (int i = 0; i < mixing.beams(); ++i) energy += mixing.at(j, i) * mixing.at(j, i);
    mixing.scale[j] = 1.0 / std::sqrt(energy);
  }
  return mixing;
}

ArrayGeometry make_array_geometry(const Sonar& sonar) {
  ENSONIFY_ASSERT(sonar.array.has_value());
  const ArrayReceiver& array = *sonar.array;
  ENSONIFY_ASSERT(array.response.size() == static_cast<std::size_t>(array.elements));
  ArrayGeometry geometry;
  for (int n = 0; n < array.elements; ++n) {
    geometry.y_m.push_back((n - (array.elements - 1) / 2.0) * array.spacing_m);
  }
  geometry.weight = array_weights(array.shading, array.elements);
  geometry.response = array.response;
  return geometry;
}

}  // namespace ensonify
