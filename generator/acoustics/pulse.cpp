#include "acoustics/pulse.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "acoustics/pattern.h"
#include "core/error.h"
#include "core/units.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// The product of std::complex checks for NaNs, which takes longer than the product itself.
Complex times(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

std::size_t radix_of(std::size_t count) {
  if (count % 4 == 0) return 4;
  for (std::size_t factor = 2; factor * factor <= count; ++factor) {
    if (count % factor == 0) return factor;
  }
  return count;
}

// An inverse Fourier transform of any length, by its prime factors.
class Transform {
 public:
  explicit Transform(std::size_t count) : turn_(count) {
    for (std::size_t k = 0; k < count; ++k) {
      turn_[k] = std::polar(1.0, 2 * kPi * static_cast<double>(k) / static_cast<double>(count));
    }
  }

  // out_j = sum_m in_m e^(i 2 pi j m / count).
  void run(const Complex* in, Complex* out) { part(in, out, turn_.size(), 1); }

 private:
  void part(const Complex* in, Complex* out, std::size_t count, std::size_t stride);
  void join_four(Complex* out, std::size_t part_count, std::size_t stride) const;
  void join(Complex* out, std::size_t radix, std::size_t part_count, std::size_t stride);

  std::vector<Complex> turn_;      // e^(i 2 pi k / count)
  std::vector<Complex> gathered_;  // scratch of join
};

// Transforms every stride-th number of `in`: the transforms of `radix` interleaved parts, joined.
void Transform::part(const Complex* in, Complex* out, std::size_t count, std::size_t stride) {
  if (count == 1) {
    *out = *in;
    return;
  }
  const std::size_t radix = radix_of(count);
  const std::size_t part_count = count / radix;
  for (std::size_t q = 0; q < radix; ++q) {
    part(in + q * stride, out + q * part_count, part_count, stride * radix);
  }
  if (radix == 4) {
    join_four(out, part_count, stride);
  } else {
    join(out, radix, part_count, stride);
  }
}

void Transform::join_four(Complex* out, std::size_t part_count, std::size_t stride) const {
  for (std::size_t k = 0; k < part_count; ++k) {
    Complex* x = out + k;
    const Complex x1 = times(x[part_count], turn_[k * stride]);
    const Complex x2 = times(x[2 * part_count], turn_[2 * k * stride]);
    const Complex x3 = times(x[3 * part_count], turn_[3 * k * stride]);
    const Complex even = x[0] + x2, even_difference = x[0] - x2;
    const Complex odd = x1 + x3, odd_difference = x1 - x3;
    const Complex quarter{-odd_difference.imag(), odd_difference.real()};
    x[0] = even + odd;
    x[part_count] = even_difference + quarter;
    x[2 * part_count] = even - odd;
    x[3 * part_count] = even_difference - quarter;
  }
}

void Transform::join(Complex* out, std::size_t radix, std::size_t part_count, std::size_t stride) {
  gathered_.resize(radix);
  const std::size_t step = part_count * stride;  // one turn / radix
  for (std::size_t k = 0; k < part_count; ++k) {
    for (std::size_t q = 0; q < radix; ++q) {
      gathered_[q] = times(out[k + q * part_count], turn_[q * k * stride]);
    }
    for (std::size_t r = 0; r < radix; ++r) {
      Complex sum = gathered_[0];
      std::size_t turned = 0;
      for (std::size_t q = 1; q < radix; ++q) {
        turned += r;
        if (turned >= radix) turned -= radix;
        sum += times(gathered_[q], turn_[turned * step]);
      }
      out[k + r * part_count] = sum;
    }
  }
}

constexpr double kEdge = 0.1;        // part of the band at each edge in which T falls
constexpr int kPeakGrid = 32;        // instants per sample
constexpr int kExtentGrid = 8;       // the same, for the search for tails
constexpr double kTailPower = 1e-9;  // -90 dB
constexpr int kLongestRecord = 1 << 16;

// T at x = (f - f_c)/b, which falls over `part` of the band at each edge.
double edge_taper(double x, double part) {
  const double into = std::abs(x) - (0.5 - part);
  if (into <= 0) return 1;
  if (into >= part) return 0;
  return 0.5 * (1 + std::cos(kPi * into / part));
}

double window_weight(Window window, double x) {
  const double turn = 2 * kPi * x;
  switch (window) {
    case Window::hann:
      return 0.5 + 0.5 * std::cos(turn);
    case Window::hamming:
      return 0.54 + 0.46 * std::cos(turn);
    case Window::blackman:
      // Zero at the band's edges; rounding must not make it negative.
      return std::max(0.0, 0.42 + 0.5 * std::cos(turn) + 0.08 * std::cos(2 * turn));
    case Window::none:
      break;
  }
  return 1;
}

// The table with phases that never jump by more than half a turn from row to row.
std::vector<PulseTableRow> unwrapped(std::vector<PulseTableRow> rows) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double jump = rows[i].phase_rad - rows[i - 1].phase_rad;
    rows[i].phase_rad = rows[i - 1].phase_rad + std::remainder(jump, 2 * kPi);
  }
  return rows;
}

Complex at_frequency(const std::vector<PulseTableRow>& rows, double frequency_hz) {
  if (frequency_hz < rows.front().frequency_hz || frequency_hz > rows.back().frequency_hz) return 0;
  const auto above = std::upper_bound(
      rows.begin() + 1, rows.end() - 1, frequency_hz,
      [](double frequency, const PulseTableRow& row) { return frequency < row.frequency_hz; });
  const PulseTableRow &low = *(above - 1), &high = *above;
  const double part = (frequency_hz - low.frequency_hz) / (high.frequency_hz - low.frequency_hz);
  return std::polar(low.amplitude + part * (high.amplitude - low.amplitude),
                    low.phase_rad + part * (high.phase_rad - low.phase_rad));
}

// P, of the transmitted pulse, at x = (f - f_c)/b. `rows` are the table's, unwrapped.
Complex sent_pulse(const Sonar& sonar, const std::vector<PulseTableRow>& rows, double x) {
  switch (sonar.pulse.shape) {
    case PulseShape::gaussian:
      return std::exp(-(kPi * x) * (kPi * x));
    case PulseShape::cw:
      return sinc(x * sonar.bandwidth_hz * sonar.pulse.duration_s);
    case PulseShape::table:
      return at_frequency(rows, sonar.frequency_hz + x * sonar.bandwidth_hz);
    case PulseShape::flat:
    case PulseShape::lfm:
      break;
  }
  return 1;
}

// W T, of the receiver.
double receiver(const Sonar& sonar, double x) {
  const bool is_lfm = sonar.pulse.shape == PulseShape::lfm;
  return window_weight(sonar.window, x) * edge_taper(x, is_lfm ? sonar.pulse.taper : kEdge);
}

// S before it is scaled.
Complex unscaled(const Sonar& sonar, const std::vector<PulseTableRow>& rows, double x) {
  return receiver(sonar, x) * sent_pulse(sonar, rows, x);
}

double peak(const std::vector<Complex>& spectrum) {
  double sum = 0;
  bool in_phase = true;  // then |s(t)| is largest at t = 0, where all bins add up
  for (const Complex& bin : spectrum) {
    sum += bin.real();
    in_phase = in_phase && bin.imag() == 0 && bin.real() >= 0;
  }
  if (in_phase) return sum;
  const std::vector<double> squared = envelope_squared(spectrum, kPeakGrid);
  return std::sqrt(*std::max_element(squared.begin(), squared.end()));
}

// The longest delay that a piece of the table gives to its part of the band, in samples.
double longest_delay(const Sonar& sonar, const std::vector<PulseTableRow>& rows) {
  double longest_s = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const PulseTableRow &low = rows[i - 1], &high = rows[i];
    if (high.frequency_hz < sonar.frequency_hz - sonar.bandwidth_hz / 2) continue;
    if (low.frequency_hz > sonar.frequency_hz + sonar.bandwidth_hz / 2) continue;
    if (low.amplitude == 0 && high.amplitude == 0) continue;
    const double slope = (high.phase_rad - low.phase_rad) / (high.frequency_hz - low.frequency_hz);
    longest_s = std::max(longest_s, std::abs(slope) / (2 * kPi));
  }
  return longest_s * sonar.bandwidth_hz;
}

// The table's rows, unwrapped; empty for other pulses.
std::vector<PulseTableRow> rows_of(const Sonar& sonar) {
  if (sonar.pulse.shape != PulseShape::table) return {};
  ENSONIFY_ASSERT(sonar.pulse.table.size() >= 2);
  return unwrapped(sonar.pulse.table);
}

std::vector<Complex> unscaled_spectrum(const Sonar& sonar, int transform) {
  ENSONIFY_ASSERT(transform >= 2 && transform % 2 == 0);
  const std::vector<PulseTableRow> rows = rows_of(sonar);
  std::vector<Complex> spectrum(transform);
  for (int m = 0; m < transform; ++m) {
    spectrum[m] = unscaled(sonar, rows, (m - transform / 2) / static_cast<double>(transform));
  }
  return spectrum;
}

// The extent in samples. The second half of the record is the time before 0.
double tabulated_extent(const Sonar& sonar, int transform) {
  const std::vector<double> squared =
      envelope_squared(unscaled_spectrum(sonar, transform), kExtentGrid);
  const double tail = kTailPower * *std::max_element(squared.begin(), squared.end());
  const long count = static_cast<long>(squared.size());
  long first = 0, last = 0;
  for (long k = 0; k < count; ++k) {
    if (squared[k] <= tail) continue;
    if (k < count / 2) {
      last = std::max(last, k + 1);
    } else {
      first = std::min(first, k - count - 1);
    }
  }
  return static_cast<double>(last - first) / kExtentGrid;
}

}  // namespace

std::vector<double> envelope_squared(const std::vector<Complex>& spectrum, int oversampling) {
  ENSONIFY_ASSERT(!spectrum.empty() && oversampling >= 1);
  const std::size_t count = spectrum.size();
  const double middle = static_cast<double>(count / 2);
  Transform transform(count);
  std::vector<Complex> shifted = spectrum, samples(count), step(count);
  for (std::size_t m = 0; m < count; ++m) {
    step[m] = std::polar(1.0, 2 * kPi * (static_cast<double>(m) - middle) /
                                  (static_cast<double>(count) * oversampling));
  }
  // One transform gives every oversampling-th instant; then the spectrum is shifted by one instant.
  std::vector<double> squared(count * oversampling);
  for (int q = 0; q < oversampling; ++q) {
    transform.run(shifted.data(), samples.data());
    for (std::size_t j = 0; j < count; ++j) squared[j * oversampling + q] = std::norm(samples[j]);
    for (std::size_t m = 0; m < count; ++m) shifted[m] = times(shifted[m], step[m]);
  }
  return squared;
}

std::vector<Complex> pulse_spectrum(const Sonar& sonar, int transform) {
  std::vector<Complex> spectrum = unscaled_spectrum(sonar, transform);
  const double highest = peak(spectrum);
  ENSONIFY_ASSERT(highest > 0);
  for (Complex& bin : spectrum) bin /= highest;
  return spectrum;
}

bool pulse_is_heard(const Sonar& sonar, int transform) {
  const std::vector<Complex> spectrum = unscaled_spectrum(sonar, transform);
  return std::any_of(spectrum.begin(), spectrum.end(),
                     [](const Complex& bin) { return bin != Complex(0); });
}

double pulse_extent_s(const Sonar& sonar) {
  if (sonar.pulse.shape == PulseShape::cw) return sonar.pulse.duration_s;
  const bool is_table = sonar.pulse.shape == PulseShape::table;
  const bool is_steep = sonar.pulse.shape == PulseShape::lfm && sonar.pulse.taper < kEdge;
  if (!is_table && !is_steep) return 0;
  // The record is first long enough for the delay of every piece of the table, then doubled until
  // the tails end.
  const double delay = is_table ? longest_delay(sonar, unwrapped(sonar.pulse.table)) : 0;
  int transform = 1024;
  while (transform < 4 * delay && transform < kLongestRecord) transform *= 2;
  for (;; transform *= 2) {
    const double extent = tabulated_extent(sonar, transform);
    if (extent <= transform / 2.0 || transform >= kLongestRecord) {
      return extent / sonar.bandwidth_hz;
    }
  }
}

double pulse_width_s(const Sonar& sonar, int transform) {
  const std::vector<double> squared =
      envelope_squared(unscaled_spectrum(sonar, transform), kPeakGrid);
  const long count = static_cast<long>(squared.size());
  const long top = std::max_element(squared.begin(), squared.end()) - squared.begin();
  const double half = squared[top] / 2;
  // Steps from the peak to half power on one side; the record is periodic.
  const auto reach = [&](long side) {
    const auto at = [&](long k) { return squared[((top + side * k) % count + count) % count]; };
    long k = 1;
    while (k < count / 2 && at(k) > half) ++k;
    const double above = at(k - 1), below = at(k);
    return static_cast<double>(k) - (below < half ? (half - below) / (above - below) : 0);
  };
  return (reach(1) + reach(-1)) / (kPeakGrid * sonar.bandwidth_hz);
}

double processing_gain(const Sonar& sonar) {
  return sonar.pulse.shape == PulseShape::lfm ? sonar.bandwidth_hz * sonar.pulse.duration_s : 1;
}

std::vector<Complex> pulse_autospectrum(const std::vector<Complex>& spectrum) {
  const std::size_t count = spectrum.size();
  std::vector<Complex> autospectrum(count);
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t m = 0; m + k < count; ++m) {
      autospectrum[k] += spectrum[m + k] * std::conj(spectrum[m]);
    }
  }
  return autospectrum;
}

double echo_step_samples(const Sonar& sonar, int transform, double level_db) {
  constexpr double kLongestStep = 1.5;
  const std::vector<Complex> spectrum = unscaled_spectrum(sonar, transform);
  const std::size_t count = spectrum.size();
  double energy = 0;
  for (const Complex& bin : spectrum) energy += std::norm(bin);
  const double most = level_db * std::log(10.0) / 10 / std::sqrt(2.0) * energy;
  for (std::size_t k = count; k-- > 0;) {
    const double step = static_cast<double>(count) / static_cast<double>(k + 1);
    if (step >= kLongestStep) break;
    Complex sum = 0;
    for (std::size_t m = 0; m + k < count; ++m) sum += spectrum[m + k] * std::conj(spectrum[m]);
    if (std::abs(sum) > most) return step;
  }
  return kLongestStep;
}

DopplerPulse make_doppler_pulse(const Sonar& sonar, int transform) {
  return {sonar, transform, rows_of(sonar), peak(unscaled_spectrum(sonar, transform))};
}

Complex doppler_bin(const DopplerPulse& pulse, double doppler, int m) {
  const Sonar& sonar = pulse.sonar;
  const double x = (m - pulse.transform / 2) / static_cast<double>(pulse.transform);
  const double sent =
      (x - doppler * sonar.frequency_hz / sonar.bandwidth_hz) / (1 + doppler);  // f' / b
  return receiver(sonar, x) * sent_pulse(sonar, pulse.table, sent) / ((1 + doppler) * pulse.peak);
}

std::vector<Complex> doppler_spectrum(const DopplerPulse& pulse, double doppler) {
  std::vector<Complex> spectrum(pulse.transform);
  for (int m = 0; m < pulse.transform; ++m) spectrum[m] = doppler_bin(pulse, doppler, m);
  return spectrum;
}

}  // namespace ensonify
