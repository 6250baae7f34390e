// Sonars that differ in their pulse alone, and the envelope of a spectrum by its definition.
#pragma once

#include <cmath>
#include <complex>
#include <vector>

#include "acoustics/pulse.h"
#include "core/units.h"

namespace ensonify {

inline Sonar with_pulse(PulseShape shape, Window window = Window::none) {
  Sonar sonar;
  sonar.frequency_hz = 900e3;
  sonar.bandwidth_hz = 29.9e3;
  sonar.range_max_m = 60;
  sonar.pulse.shape = shape;
  sonar.pulse.duration_s = 1e-3;
  sonar.window = window;
  return sonar;
}

inline Sonar with_cw(double duration_s, Window window = Window::none) {
  Sonar sonar = with_pulse(PulseShape::cw, window);
  sonar.pulse.duration_s = duration_s;
  return sonar;
}

inline Sonar with_lfm(double taper, Window window = Window::none) {
  Sonar sonar = with_pulse(PulseShape::lfm, window);
  sonar.pulse.taper = taper;
  return sonar;
}

// A table of `rows` equal steps over x = (f - f_c)/b in [low, high].
template <class Amplitude, class Phase>
Sonar with_table(int rows, double low, double high, const Amplitude& amplitude,
                 const Phase& phase_rad) {
  Sonar sonar = with_pulse(PulseShape::table);
  for (int i = 0; i < rows; ++i) {
    const double x = low + (high - low) * i / (rows - 1);
    sonar.pulse.table.push_back(
        {sonar.frequency_hz + x * sonar.bandwidth_hz, amplitude(x), phase_rad(x)});
  }
  return sonar;
}

// s at time x samples, term by term.
inline std::complex<double> pulse_at(const std::vector<std::complex<double>>& spectrum, double x) {
  const int count = static_cast<int>(spectrum.size());
  std::complex<double> sum = 0;
  for (int m = 0; m < count; ++m) {
    sum += spectrum[m] * std::polar(1.0, 2 * kPi * (m - count / 2) * x / count);
  }
  return sum;
}

inline double amplitude_db(double amplitude) { return 20 * std::log10(amplitude); }

}  // namespace ensonify
