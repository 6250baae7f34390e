// A ping of given echoes, as the labels take it.
#pragma once

#include <cmath>
#include <complex>
#include <cstdint>
#include <utility>
#include <vector>

#include "labels/polar.h"

namespace ensonify::test {

// At 1500 m/s a sample is a meter.
inline constexpr double kMeterBandwidth_hz = 750, kMeterSpeed_m_s = 1500;

// A direct echo of that bandwidth with E|a|^2 gain^2 = energy.
inline Scatterer direct_echo(std::uint32_t beam, double range_m, std::uint32_t instance,
                             double energy, double elevation_rad = 0) {
  Scatterer s;
  s.beam = beam;
  s.delay_s = range_m / kMeterBandwidth_hz;
  s.instance = instance;
  s.gain = 2;
  s.standard_deviation = static_cast<float>(std::sqrt(energy) / 2);
  s.arrival.elevation_rad = static_cast<float>(elevation_rad);
  return s;
}

// A volume of an instance that is silent in all cells.
inline VolumeEcho empty_volume(std::uint32_t instance, int cells) {
  VolumeEcho volume;
  volume.instance = instance;
  volume.energy.resize(cells);
  volume.elevation_rad.resize(cells);
  volume.elevation_square.resize(cells);
  return volume;
}

struct PolarPing {
  ScattererList list;
  std::vector<VolumeEcho> volumes;
  std::vector<std::complex<float>> pressure;
  std::vector<float> clean;
  std::vector<std::uint8_t> classes;
  PolarInput input;

  PolarPing(std::vector<Scatterer> echoes, int beams, int samples, double bandwidth_hz,
            std::vector<std::uint8_t> class_of_instance)
      : list(sorted_by_beam_and_delay(std::move(echoes), beams)),
        pressure(std::size_t(beams) * samples, {1e-3f, 0}),
        clean(pressure.size(), 1e-6f),
        classes(std::move(class_of_instance)) {
    input.scatterers = &list;
    input.pressure_pa = pressure;
    input.clean_power_pa2 = clean;
    input.bandwidth_hz = bandwidth_hz;
    input.beams = beams;
    input.samples = samples;
    input.class_of_instance = classes;
  }
  PolarPing(const PolarPing&) = delete;
  PolarPing& operator=(const PolarPing&) = delete;

  LabelledImage image(int threads = 2) {
    input.volumes = volumes;
    return polar_image(input, Workers(threads));
  }
};

}  // namespace ensonify::test
