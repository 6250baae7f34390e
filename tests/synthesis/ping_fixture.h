// Sonars, scatterers and single pings for the tests of synthesis.
#pragma once

#include <cmath>
#include <complex>
#include <memory>
#include <vector>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "acoustics/pulse.h"
#include "core/random.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "synthesis/backend.h"

namespace ensonify::test {

inline SynthesisSetup setup_of(const Sonar& sonar) {
  const Water water{1500, 0};
  return {sonar, water, make_record(sonar, water, pulse_extent_s(sonar))};
}

// A pulse of a shape, the table's one lopsided in amplitude and delay: its spectrum is complex.
inline Pulse pulse_of(PulseShape shape, const Sonar& sonar) {
  Pulse pulse{shape, 0, 0.1, {}};
  if (shape == PulseShape::lfm) pulse.duration_s = 1e-3;
  if (shape == PulseShape::cw) pulse.duration_s = 4 / sonar.bandwidth_hz;
  if (shape == PulseShape::table) {
    for (int i = 0; i <= 16; ++i) {
      const double x = i / 16.0 - 0.5;  // of the band
      pulse.table.push_back({sonar.frequency_hz + x * sonar.bandwidth_hz, 1 + x - x * x,
                             -2 * kPi * 1.3 * x + 9 * x * x - 20 * x * x * x});
    }
  }
  return pulse;
}

// A point target of strength TS in the middle of a sector.
inline Scatterer point_target(const Sonar& sonar, int beam, double range_m, double ts_db) {
  Scatterer s;
  s.delay_s = two_way_delay_s(range_m, 1500);
  s.gain = static_cast<float>(two_way_loss(range_m, 0));
  s.mean = static_cast<float>(std::pow(10, ts_db / 20));
  s.beam = static_cast<std::uint32_t>(beam);
  s.arrival.azimuth_rad = static_cast<float>(beam_azimuth_rad(sonar, beam));
  return s;
}

// A target of 0 dB at 1.5 m, and `far_db` ones a metre apart beyond `far_m`; every second is
// diffuse.
inline std::vector<Scatterer> strong_before_faint(const Sonar& sonar, int count, double far_m,
                                                  double far_db) {
  std::vector<Scatterer> scatterers;
  for (int i = 0; i < count; ++i) {
    const double range_m = i == 0 ? 1.5 : far_m + i;
    Scatterer s = point_target(sonar, (3 * i) % sonar.beam_count, range_m, i == 0 ? 0 : far_db);
    s.gain = static_cast<float>(two_way_loss(range_m, 0.3));
    s.key = i;
    if (i % 2 == 1) {
      s.standard_deviation = s.mean.real();
      s.mean = 0;
    }
    scatterers.push_back(s);
  }
  return scatterers;
}

// `count` diffuse scatterers at random places of the fan from `near_m` to the end of the record,
// a tenth of them with a mean as well.
inline std::vector<Scatterer> random_scatterers(const Sonar& sonar, int count, double near_m,
                                                std::uint64_t seed) {
  std::vector<Scatterer> scatterers(count);
  for (int i = 0; i < count; ++i) {
    const auto draw = [&](std::uint32_t d) { return uniform(seed, 0, i, d); };
    Scatterer& s = scatterers[i];
    const double range = near_m + (sonar.range_max_m - near_m) * draw(0);
    s.delay_s = two_way_delay_s(range, 1500);
    s.gain = static_cast<float>(two_way_loss(range, 0.3));
    s.beam = static_cast<std::uint32_t>(draw(1) * sonar.beam_count);
    s.standard_deviation = static_cast<float>(0.01 * range * draw(2));
    if (i % 10 == 0)
      s.mean = {static_cast<float>(0.01 * draw(3)), static_cast<float>(-0.02 * draw(4))};
    s.key = i;
  }
  return scatterers;
}

// A volume with energy(beam, sample) in its cells.
template <class Energy>
VolumeEcho volume_of(const SynthesisSetup& setup, Energy&& energy) {
  VolumeEcho volume;
  for (int beam = 0; beam < setup.sonar.beam_count; ++beam) {
    for (int n = 0; n < setup.record.samples; ++n) {
      volume.energy.push_back(static_cast<float>(energy(beam, n)));
    }
  }
  return volume;
}

inline RandomKeys keys_of_ping(std::uint32_t ping, std::uint64_t seed = 9) {
  RandomKeys keys;
  keys.speckle = stream_key(seed, Stream::speckle, 0);
  keys.volume = stream_key(seed, Stream::volume, 0);
  keys.speckle_ping = ping;
  return keys;
}

inline PingSeries synthesize(const Backend& backend, const ScattererList& list,
                             RandomKeys keys = {}, double noise_power_pa2 = 0,
                             std::span<const VolumeEcho> volumes = {},
                             const Workers& workers = Workers(2)) {
  const PingTask task{&list, keys, noise_power_pa2, volumes};
  PingSeries series;
  backend.synthesize({&task, 1}, {&series, 1}, workers);
  return series;
}

}  // namespace ensonify::test
