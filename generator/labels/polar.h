// Ground truth of a ping in the sonar's own coordinates: rows are samples, columns beams.
//
//   polar_image     level, clean level, instance, semantic class, elevation
//   hears_echo      which pixels hear anything of their own sector
//   first_return_m  where each beam first meets something
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
  std::span<const std::complex<float>> pressure_pa;  // [beams x samples]; empty: level_db is there
  std::span<const float> level_db;                   // [samples x beams], image_level_db of it
  std::span<const float> clean_power_pa2;            // [beams x samples]
  double noise_power_pa2 = 0;                        // 0: no noise
  double bandwidth_hz = 0;
  int beams = 0, samples = 0;
  std::span<const std::uint8_t> class_of_instance;  // by instance id; [0] is 0
  std::span<const VolumeEcho> volumes;
  bool multipath = false;  // the mask of bounced echoes is asked for
};

// The image and its labels. A pixel hears the echoes of its own sector (no side lobes) within
// c/2b of its sample that have any energy. Its instance is the one with the most expected energy,
// E|a|^2 gain^2 summed without phase; ties go to the lower id. None where there is no echo, or
// where noise is given and the pixel's clean power lies under it; then the fraction is 0.
// Elevation: energy-weighted mean and standard deviation over all echoes of the pixel, NaN where
// there is none. Bounced echoes (path != 0) are nowhere counted but in the energy that the fraction
// is of, and in `multipath`, where `input` asks for it: the instance with most bounced energy where
// this is more than the direct energy and noise does not forbid a label; ties go to the lower id. A
// volume counts with its energy of the pixel's own sample and half that of the two beside it.
// Levels are those of core/units.h.
LabelledImage polar_image(const PolarInput& input, const Workers& workers);

// [beams x samples]: 1 where the pixel hears an echo, as above; noise does not matter.
std::vector<std::uint8_t> hears_echo(const ScattererList& scatterers,
                                     std::span<const VolumeEcho> volumes, double bandwidth_hz,
                                     int beams, int samples);

// Slant range of the nearest direct scatterer of each sector, [beams]; NaN where there is none.
// Volumes are no return. Where rays are refracted or the sonar moves within the ping, what the
// range axis says: `instrument_speed_m_s` times half the delay; 0: the distance itself.
std::vector<float> first_return_m(const ScattererList& scatterers, int beams,
                                  double instrument_speed_m_s = 0);

}  // namespace ensonify
