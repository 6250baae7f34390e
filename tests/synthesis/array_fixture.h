// Element-level arrays for the tests of synthesis.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "synthesis/beamforming.h"
#include "synthesis/device_fixture.h"

namespace ensonify::test {

// The backends that every case of an array runs on.
struct ArrayBackend {
  const char* name;
  std::unique_ptr<Backend> (*make)(const SynthesisSetup&);
  bool has_exact_power;  // expected power is its definition, grating lobes included
};
inline const std::vector<ArrayBackend> kArrayBackends = {
    {"reference", make_reference_backend, true},
    {"cpu", make_cpu_backend, false},
    {"device", [](const SynthesisSetup& setup) { return host_device(setup); }, false},
};

inline constexpr double kWavelengthM = 1500 / 900e3;

// `elements` at half a wavelength, sound ones; bandwidth as given.
inline Sonar line_array(int elements, int beams, double fov_deg, double range_max_m,
                        double bandwidth_hz = 29.9e3) {
  Sonar sonar = p900(beams, fov_deg, range_max_m);
  sonar.bandwidth_hz = bandwidth_hz;
  ArrayReceiver& array = sonar.array.emplace();
  array.elements = elements;
  array.spacing_m = kWavelengthM / 2;
  array.response.assign(elements, 1.0);
  return sonar;
}

// A point target anywhere, straight there and back.
inline Scatterer target_at(const Sonar& sonar, double azimuth_deg, double elevation_deg,
                           double range_m) {
  Scatterer s = point_target(sonar, 0, range_m, 0);
  s.gain = 1;
  s.beam = sector_of(sonar, radians(azimuth_deg)).value_or(0);
  s.arrival = {static_cast<float>(radians(azimuth_deg)),
               static_cast<float>(radians(elevation_deg))};
  s.received_path_m = static_cast<float>(range_m);
  return s;
}

// Amplitude of the echo of one target in every beam at the sample of its range, over that of a
// sound element on the boresight.
inline std::vector<double> beam_cut(const ArrayBackend& kind, const Sonar& sonar,
                                    const Scatterer& target) {
  const SynthesisSetup setup = setup_of(sonar);
  const ScattererList list = sorted_by_beam_and_delay({target}, sonar.beam_count);
  const PingTask task{&list, {}, 0, {}, false};
  PingSeries series;
  kind.make(setup)->synthesize({&task, 1}, {&series, 1}, Workers(2));
  const auto sample = static_cast<std::size_t>(std::lround(target.delay_s * sonar.bandwidth_hz));
  std::vector<double> cut;
  for (int j = 0; j < sonar.beam_count; ++j) {
    const std::complex<float> p = series.pressure_pa[j * setup.record.samples + sample];
    cut.push_back(std::abs(std::complex<double>(p)) / source_pressure_pa_m(sonar));
  }
  return cut;
}

inline double decibels(double amplitude) { return 20 * std::log10(std::abs(amplitude)); }

inline std::size_t peak_of(const std::vector<double>& cut) {
  return static_cast<std::size_t>(std::max_element(cut.begin(), cut.end()) - cut.begin());
}

// Level of the highest lobe outside the first minima, over the peak.
inline double highest_lobe_db(const std::vector<double>& cut) {
  const std::size_t peak = peak_of(cut);
  double highest = 0;
  std::size_t i = peak;
  while (i + 1 < cut.size() && cut[i + 1] < cut[i]) ++i;
  for (; i < cut.size(); ++i) highest = std::max(highest, cut[i]);
  i = peak;
  while (i > 0 && cut[i - 1] < cut[i]) --i;
  for (std::size_t k = 0; k < i; ++k) highest = std::max(highest, cut[k]);
  return decibels(highest / cut[peak]);
}

// The worst of what reaches within 40 dB of the maximum.
inline double worst_db(std::span<const float> a, std::span<const float> b) {
  REQUIRE(a.size() == b.size());
  const float largest = *std::max_element(b.begin(), b.end());
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (b[i] < 1e-4 * largest) continue;
    worst = std::max(worst, std::abs(10 * std::log10(double(a[i]) / b[i])));
  }
  return worst;
}

// Echoes from everywhere in the fan, some elevated, from the bow of the array to the record's end.
inline std::vector<Scatterer> fan_echoes(const Sonar& sonar, int count, double near_m,
                                         std::uint64_t seed = 77) {
  std::vector<Scatterer> items = random_scatterers(sonar, count, near_m, seed);
  for (std::size_t i = 0; i < items.size(); ++i) {
    Scatterer& s = items[i];
    const double azimuth =
        (uniform(seed, 1, i, 0) - 0.5) * sonar.beam_spacing_rad * sonar.beam_count;
    s.arrival = {static_cast<float>(azimuth),
                 static_cast<float>(radians(20) * (uniform(seed, 1, i, 1) - 0.5))};
    s.received_path_m = static_cast<float>(s.delay_s * 750 * (0.9 + 0.2 * uniform(seed, 1, i, 2)));
    s.beam = sector_of(sonar, s.arrival.azimuth_rad).value_or(0);
  }
  return items;
}

inline ScattererList list_of(const Sonar& sonar, std::vector<Scatterer> items) {
  return sorted_by_beam_and_delay(std::move(items), sonar.beam_count);
}

}  // namespace ensonify::test
