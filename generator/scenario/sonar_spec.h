// The keys of a sonar.
//
//   SonarSpec
//   PulseSpec  ArraySpec  ElectronicsSpec  TransmitSpec  RecorderSpec   its parts
//   dead_trouble
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/detector.h"
#include "core/electronics.h"
#include "core/sonar.h"
#include "scenario/path_spec.h"

namespace ensonify {

// `duration_s` of lfm and cw and `file` of table are required.
struct PulseSpec {
  PulseShape shape = PulseShape::gaussian;
  double duration_s = 0;
  double taper = 0.1;          // for lfm
  std::filesystem::path file;  // for table: CSV with frequency_hz, amplitude, phase_deg
};

// Absent values follow from the rest of the sonar and the water: ping/array_receiver.h.
struct ArraySpec {
  std::optional<int> elements;
  std::optional<double> spacing_m;
  double element_width_m = 0;
  std::optional<BeamShading> shading;
  Focus focus = Focus::dynamic;
  Steering steering = Steering::true_delay;
  double gain_error_db = 0;    // standard deviation over elements
  double phase_error_deg = 0;  // the same
  std::vector<int> dead;       // indices
};

inline constexpr int kMaxElements = 4096;

// The error in the indices of dead elements, with the expected values; empty if they are valid.
std::string dead_trouble(const std::vector<int>& dead, int elements);

struct ElectronicsSpec {
  double beam_gain_error_db = 0, beam_phase_error_deg = 0;  // standard deviations
  double interference_azimuth_deg = 0;
  FrontEnd front_end;  // without beam responses
};

struct TransmitSpec {
  TransmitGroups groups;             // without the interval
  std::optional<double> interval_s;  // absent: the echo from range_max_m has returned, and
  double turnaround_s = 0;           // ... this time has passed
  std::optional<double> width_deg;   // absent: the receive width of the beam
};

struct RecorderSpec {
  Recorder recorder;
  double dropped = 0;  // probability of a frame
};

// The keys of a preset, overridden by the keys that are given with it. Required without a preset:
// all but pulse, window, range_min_m, beams.shading, beams.transmit_width_deg, elevation.shading,
// elevation.fan_deg, rays.azimuth, rays.min_per_cell, receiver and mount.
struct SonarSpec {
  double frequency_hz = 0;
  double bandwidth_hz = 0;
  PulseSpec pulse;
  Window window = Window::none;
  double source_level_db = 0;
  double range_min_m = 0;
  double range_max_m = 0;
  int beam_count = 0;
  double beam_fov_deg = 0;    // spacing_deg times count or between the ends of azimuths_deg
  double beam_width_deg = 0;  // the mean of receive_widths_deg if they were given
  std::vector<double> azimuths_deg = {};        // empty: equally spaced over beam_fov_deg
  std::vector<double> receive_widths_deg = {};  // empty: all beam_width_deg
  BeamShading shading;
  std::optional<double> transmit_width_deg;  // absent: uniform over the fan
  double elevation_width_deg = 0;
  BeamShading elevation_shading;
  double elevation_fan_deg = 0;  // if left out: the beam width
  int rays_elevation = 0;
  int rays_azimuth = 1;
  std::optional<int> rays_per_cell;  // 0: no adaptive refinement; absent: by need
  std::optional<ArraySpec> array;    // absent: mode beams
  std::optional<Adc> adc;
  std::optional<Detector> detector = {};            // absent: the level is that of |p|^2
  std::optional<TransmitSpec> transmit = {};        // absent: all beams together
  std::optional<ElectronicsSpec> electronics = {};  // absent: ideal
  std::optional<RecorderSpec> recorder = {};        // absent: no counts
  PoseSpec mount;
  std::vector<std::string> notices = {};  // about values of a preset that no longer fit others
};

}  // namespace ensonify
