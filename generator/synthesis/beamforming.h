// How beams are formed from ideal beam cells, and from the elements of a receiving line array.
// These are the sums that every backend computes.
//
// Ideal beam cells add up to real beams by their patterns (Choi et al. 2021, Eq 16 and 17).
//
// Element n of an array hears from all scatterers i (Eq 8, with its own path to each)
//   p_n(t) = response_n sum_i E(u_i) a_i gain_i S0 e^(-i 2 pi f_c (tau_i + delta_ni))
//                       s(t - tau_i - delta_ni)
// where delta_ni is the additional delay on the path to it, u_i the cosine between arrival and
// line, and E the pattern of one element. Beam j adds the elements up:
//   y_j(t) = sum_n weight_n e^(i 2 pi f_c (D_nj + F_nj(t))) p_n(t + D_nj)
// with the steering delay D_nj and the focus F_nj(t), a phase at the carrier. Without focus,
// F = 0. With steering by phase, p_n(t) replaces p_n(t + D_nj).
//
//   Mixing  make_mixing                                   for beam cells
//   ArrayGeometry  make_array_geometry
//   apparent_point_m  arrival_cosine  element_delay_s  element_pattern   for scatterers
//   steering_delay_s  focus_range_m  focus_delay_s        for beams
//   element_noise_power_pa2
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <vector>

#include "acoustics/pattern.h"
#include "core/scatterers.h"
#include "core/sonar.h"
#include "core/vec.h"

namespace ensonify {

struct Mixing {
  // [count], B_az at a distance of k beam cells; even in k. Empty if beams are unequal.
  std::vector<double> weight;
  std::vector<double> scale;  // [count], 1 / N_j
  // Of unequal beams, and of groups that transmit in turn: [beams][cells] and the azimuths of the
  // middles of cells; otherwise empty.
  std::vector<double> matrix = {}, middle_rad = {};

  int beams() const { return static_cast<int>(scale.size()); }
  bool is_equal() const { return matrix.empty(); }
  double at(int beam, int cell) const {
    return is_equal() ? weight[std::abs(cell - beam)]
                      : matrix[std::size_t(beam) * scale.size() + cell];
  }
};

// p_j = scale_j sum_i w_ji p_i with w_ji = B_az,j(theta_i - theta_j), theta_i the middle of beam
// cell i. Of equal beams, the weight depends on the distance of the cells only. Where groups of
// beams transmit in turn, w_ji is multiplied by the lobe that the group of beam j sends toward
// theta_i, B_tx(theta_i - theta_k) with the beam k of the group that is nearest to theta_i. N_j = 1
// (calibrated) or sqrt(sum_i w_ji^2) (mean_square, Eq 16).
Mixing make_mixing(const Sonar& sonar);

struct ArrayGeometry {
  std::vector<double> y_m;                     // [elements], sonar frame
  std::vector<double> weight;                  // [elements], sum 1
  std::vector<std::complex<double>> response;  // [elements]
};

// Needs sonar.array.
ArrayGeometry make_array_geometry(const Sonar& sonar);

// The point from which the sound of a scatterer seems to come, in the sonar's frame.
inline Vec3 apparent_point_m(const Scatterer& s) {
  return static_cast<double>(s.received_path_m) *
         unit_vector(s.arrival.azimuth_rad, s.arrival.elevation_rad);
}

// u: the cosine between the direction of arrival and the line of elements.
inline double arrival_cosine(const Scatterer& s) {
  return std::cos(static_cast<double>(s.arrival.elevation_rad)) *
         std::sin(static_cast<double>(s.arrival.azimuth_rad));
}

// The delay of the sound from a point at y relative to the origin. The point must not be the
// origin.
inline double element_delay_s(Vec3 apparent_m, double y_m, double sound_speed_m_s) {
  const double from_origin = length(apparent_m);
  const double from_element = length(apparent_m - Vec3{0, y_m, 0});
  return (y_m * y_m - 2 * y_m * apparent_m.y) / ((from_element + from_origin) * sound_speed_m_s);
}

inline double wavelength_m(const Sonar& sonar, const Water& water) {
  return water.sound_speed_m_s / sonar.frequency_hz;
}

// Amplitude of one element, sinc(width u / lambda), where u is the cosine between arrival and line.
inline double element_pattern(double u, double element_width_m, double wavelength_m) {
  return sinc(element_width_m * u / wavelength_m);
}

// D: the delay at y, relative to the origin, of a plane wave from an azimuth at elevation 0.
inline double steering_delay_s(double y_m, double azimuth_rad, double sound_speed_m_s) {
  return -y_m * std::sin(azimuth_rad) / sound_speed_m_s;
}

// Range of the dynamic focus at sample n: c n/(2b), but at least that of sample 1.
inline double focus_range_m(const Sonar& sonar, const Water& water, int sample) {
  return sample_range_m(sonar, water, std::max(sample, 1));
}

// F: the delay at y of a wave from range r on the beam's axis, relative to a plane wave.
inline double focus_delay_s(double y_m, double azimuth_rad, double range_m,
                            double sound_speed_m_s) {
  const double along = y_m * std::sin(azimuth_rad);
  const double from_element = std::sqrt(range_m * range_m - 2 * range_m * along + y_m * y_m);
  const double longer_m = (y_m * y_m - 2 * range_m * along) / (from_element + range_m);
  return (longer_m + along) / sound_speed_m_s;
}

// Noise power of one element. Noise is drawn independently for every element and sample, with the
// power that gives `beam_noise_power_pa2` in a beam whose elements all work. Dead elements have no
// noise.
inline double element_noise_power_pa2(const ArrayGeometry& geometry, double beam_noise_power_pa2) {
  double sum = 0;
  for (const double w : geometry.weight) sum += w * w;
  return beam_noise_power_pa2 / sum;
}

}  // namespace ensonify
