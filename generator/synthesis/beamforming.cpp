#include "synthesis/beamforming.h"

#include <cmath>

#include "acoustics/pattern.h"
#include "core/error.h"

namespace ensonify {

namespace {

// What the group of each beam sends toward the middles of the beam cells, [beams x cells]: the lobe
// about that beam of the group which is nearest to the cell.
void send_in_groups(const Sonar& sonar, Mixing& mixing) {
  const int beams = sonar.beam_count;
  std::vector<ShadedLine> lobe;
  for (int j = 0; j < beams; ++j) {
    const double width = sonar.transmit->width_rad;
    lobe.push_back(make_shaded_line({}, width > 0 ? width : width_of_beam_rad(sonar, j)));
  }
  for (int i = 0; i < beams; ++i) {
    const auto off_axis = [&](int beam) {
      return std::abs(mixing.middle_rad[i] - beam_azimuth_rad(sonar, beam));
    };
    for (int group = 0; group < group_count(sonar); ++group) {
      const auto [first, step, count] = beams_of_group(sonar, group);
      int nearest = first;
      for (int k = 1; k < count; ++k) {
        const int beam = first + k * step;
        if (off_axis(beam) < off_axis(nearest)) nearest = beam;
      }
      const double sent = shaded_pattern(lobe[nearest], off_axis(nearest));
      for (int k = 0; k < count; ++k) {
        mixing.matrix[std::size_t(first + k * step) * beams + i] *= sent;
      }
    }
  }
}

Mixing unscaled_mixing(const Sonar& sonar) {
  const int count = sonar.beam_count;
  const bool in_turn = group_count(sonar) > 1;
  Mixing mixing;
  mixing.scale.assign(count, 1.0);
  if (has_equal_beams(sonar) && !in_turn) {
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
  if (in_turn) send_in_groups(sonar, mixing);
  return mixing;
}

}  // namespace

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
