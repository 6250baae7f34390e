// Ground truth of a ping in the sonar's own coordinates: rows are samples, columns beams.
//
//   polar_image     level, expected level, instance, semantic class, elevation
//   hears_echo      which pixels hear an echo of their beam cell
//   first_return_m  range of the nearest echo of each beam cell
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/ping.h"
#include "core/scatterers.h"

namespace ensonify {

struct PolarInput {
  const ScattererList* scatterers = nullptr;
  std::span<const std::complex<float>> pressure_pa;  // [beams x samples]; empty: level_db is given
  std::span<const float> level_db;                   // [samples x beams], by image_level_db
  std::span<const float> clean_power_pa2;            // [beams x samples]
  double noise_power_pa2 = 0;                        // 0: no noise
  double bandwidth_hz = 0;
  int beams = 0, samples = 0;
  std::span<const std::uint8_t> class_of_instance;  // by instance id; [0] is 0
  std::span<const VolumeEcho> volumes;
  bool multipath = false;  // whether the mask of bounced echoes is wanted
  bool second = false;     // whether the second instance is wanted
};

// The image and its labels. A pixel hears the echoes of its beam cell (no side lobes) within c/2b
// of its sample that have any energy. Its instance is the one with the most expected energy, E|a|^2
// gain^2 summed without phase; if two have equal energy, the lower id wins. The pixel has no
// instance if there is no echo, or if noise is given and the pixel's expected power is below it;
// then the fraction is 0. Elevation: energy-weighted mean and standard deviation over all echoes of
// the pixel, NaN if there are none. Bounced echoes (path != 0) count only in the total energy for
// the fraction, and in `multipath` if `input` requests it. The latter is the instance with the most
// bounced energy, if that energy exceeds the direct energy and noise does not forbid a label; the
// lower id wins if two are equal. If `input` requests it, `second_instance` is the instance with the
// most direct energy after the pixel's own, 0 if there is none, and `second_fraction` is its share
// in the total energy. A volume counts with its energy in the pixel's own sample and
// half of that in the two adjacent ones. Levels are those of core/units.h.
LabelledImage polar_image(const PolarInput& input, const Workers& workers);

// [beams x samples]: 1 if the pixel hears an echo, as above; noise does not matter.
std::vector<std::uint8_t> hears_echo(const ScattererList& scatterers,
                                     std::span<const VolumeEcho> volumes, double bandwidth_hz,
                                     int beams, int samples);

// Slant range of the nearest direct scatterer of each beam cell, [beams]; NaN if there is none.
// Volumes do not count. If rays are refracted or the sonar moves within the ping, it is the value
// on the range axis: `instrument_speed_m_s` times half the delay. If `instrument_speed_m_s` is 0,
// it is the distance itself.
std::vector<float> first_return_m(const ScattererList& scatterers, int beams,
                                  double instrument_speed_m_s = 0);

}  // namespace ensonify
