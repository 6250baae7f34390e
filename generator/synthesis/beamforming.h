// How beams are formed: of ideal beam cells, and of the elements of a receiving line array. This is
// what every backend sums.
//
// Ideal beam cells add up to real beams by their patterns (Choi et al. 2021, Eq 16 and 17).
//
// Element n of an array hears, of every scatterer i (Eq 8, with a path of its own),
//   p_n(t) = response_n sum_i E(u_i) a_i gain_i S0 e^(-i 2 pi f_c (tau_i + delta_ni))
//                       s(t - tau_i - delta_ni)
// with delta_ni the longer path to it, u_i the cosine of arrival along the line, and E the pattern
// of one element. Beam j adds them up:
//   y_j(t) = sum_n weight_n e^(i 2 pi f_c (D_nj + F_nj(t))) p_n(t + D_nj)
// with the steering delay D_nj and the focus F_nj(t), a phase at the carrier; F = 0 without focus,
// and p_n(t) stands for p_n(t + D_nj) where the steering is by phase.
//
//   Mixing  make_mixing                                   of sectors
//   ArrayGeometry  make_array_geometry
//   apparent_point_m  element_delay_s  element_pattern    of scatterers
//   steering_delay_s  focus_range_m  focus_delay_s        of beams
//   element_noise_power_pa2
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "acoustics/pattern.h"
#include "core/scatterers.h"
#include "core/sonar.h"
#include "core/vec.h"

namespace ensonify {

struct Mixing {
  std::vector<double> weight;  // [count], B_az at a distance of k sectors; even in k
  std::vector<double> scale;   // [count], 1 / N_j
};

// p_j = scale_j sum_i weight_|i-j| p_i. Sectors are equally spaced, so that one weight a distance
// says all. N_j = 1 (calibrated) or sqrt(sum_i weight^2) (mean_square, Eq 16).
Mixing make_mixing(const Sonar& sonar);

struct ArrayGeometry {
  std::vector<double> y_m;                     // [elements], sonar frame
  std::vector<double> weight;                  // [elements], sum 1
  std::vector<std::complex<double>> response;  // [elements]
};

// Needs sonar.array.
ArrayGeometry make_array_geometry(const Sonar& sonar);

// Where the sound of a scatterer seems to come from, in the sonar's frame.
inline Vec3 apparent_point_m(const Scatterer& s) {
  return static_cast<double>(s.received_path_m) *
         unit_vector(s.arrival.azimuth_rad, s.arrival.elevation_rad);
}

// How much later than at the origin the sound from a point (not the origin) is at y.
inline double element_delay_s(Vec3 apparent_m, double y_m, double sound_speed_m_s) {
  const double from_origin = length(apparent_m);
  const double from_element = length(apparent_m - Vec3{0, y_m, 0});
  return (y_m * y_m - 2 * y_m * apparent_m.y) / ((from_element + from_origin) * sound_speed_m_s);
}

inline double wavelength_m(const Sonar& sonar, const Water& water) {
  return water.sound_speed_m_s / sonar.frequency_hz;
}

// Amplitude of one element against u, the cosine between arrival and line: sinc(width u / lambda).
inline double element_pattern(double u, double element_width_m, double wavelength_m) {
  return sinc(element_width_m * u / wavelength_m);
}

// D: how much later a plane wave from an azimuth in the plane of elevation 0 is at y.
inline double steering_delay_s(double y_m, double azimuth_rad, double sound_speed_m_s) {
  return -y_m * std::sin(azimuth_rad) / sound_speed_m_s;
}

// Where dynamic focus lies at sample n: c n/(2b), and no nearer than at sample 1.
inline double focus_range_m(const Sonar& sonar, const Water& water, int sample) {
  return sample_range_m(sonar, water, std::max(sample, 1));
}

// F: by how much a wave from range r on the beam's axis is later at y than a plane one.
inline double focus_delay_s(double y_m, double azimuth_rad, double range_m,
                            double sound_speed_m_s) {
  const double along = y_m * std::sin(azimuth_rad);
  const double from_element = std::sqrt(range_m * range_m - 2 * range_m * along + y_m * y_m);
  const double longer_m = (y_m * y_m - 2 * range_m * along) / (from_element + range_m);
  return (longer_m + along) / sound_speed_m_s;
}

// Noise is drawn for every element and sample on its own, so strong that a beam of sound elements
// has `beam_noise_power_pa2`. Dead elements have none.
inline double element_noise_power_pa2(const ArrayGeometry& geometry, double beam_noise_power_pa2) {
  double sum = 0;
  for (const double w : geometry.weight) sum += w * w;
  return beam_noise_power_pa2 / sum;
}

}  // namespace ensonify
