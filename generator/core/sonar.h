// The instrument, the water and the record as plain numbers, in SI units and radians.
//
//   Pulse  Window  BeamShading  ShadedLine  ArrayReceiver  Adc  TransmitGroups   parts of it
//   name_of                                 their words in scenarios and files
//   Sonar    the instrument                 has_equal_beams  beam_azimuth_rad  beam_borders_rad
//                                           beam_place  sector_of  width_of_beam_rad
//                                           cell_width_rad  cell_middle_rad
//                                           narrowest_cell_rad
//                                           furthest_azimuth_rad
//                                           group_count  group_of  beams_of_group
//                                           fired_after_s  carrier_hz  carrier_of_beam_hz
//   Water    sound speed and absorption
//   Record   samples and transform length   make_record  sample_range_m
//                                           range_step_m
#pragma once

#include <complex>
#include <optional>
#include <vector>

#include "core/detector.h"
#include "core/electronics.h"
#include "core/vec.h"

namespace ensonify {

enum class PulseShape { gaussian, flat, lfm, cw, table };

// One frequency of a measured pulse.
struct PulseTableRow {
  double frequency_hz = 0;
  double amplitude = 0;  // of any scale: the pulse is scaled to unit peak
  double phase_rad = 0;  // engineering sign: a delay tau has the phase -2 pi f tau
};

struct Pulse {
  PulseShape shape = PulseShape::gaussian;
  double duration_s = 0;             // of lfm and cw
  double taper = 0.1;                // of lfm: the part of the band that falls off at each edge
  std::vector<PulseTableRow> table;  // of table, by rising frequency
};

// Spectral window of the receiver over the band.
enum class Window { none, hann, hamming, blackman };

// The weights of the receiving array's elements. Every shading keeps the -3 dB width of the beam.
enum class Shading { uniform, hann, taylor, chebyshev };
struct BeamShading {
  Shading kind = Shading::uniform;
  double side_lobe_db = -35;  // of taylor and chebyshev, against the main lobe
  int nbar = 5;               // of taylor: side lobes up to this one are near side_lobe_db
};

// A line aperture with such weights: make_shaded_line of acoustics/pattern.h, which has the
// formulas.
struct ShadedLine {
  BeamShading shading;
  double aperture = 0;       // in wavelengths
  double a_squared = 0;      // A^2, of taylor and chebyshev
  double sigma_squared = 0;  // of taylor
};

// dynamic: each sample is focused on the point of the beam from which its echo arrives, in the
// plane of elevation 0. none: focus at infinity.
enum class Focus { none, dynamic };
// How beams are steered to their azimuth: by delaying the whole signal, or by the carrier's phase.
enum class Steering { true_delay, phase };

// A line of elements along the sonar's y axis, about its origin: element n at
// y = (n - (elements - 1)/2) spacing. Sound goes out from the origin.
struct ArrayReceiver {
  int elements = 0;
  double spacing_m = 0;
  double element_width_m = 0;  // aperture of each along the line; 0: omnidirectional
  BeamShading shading;         // weights of the elements, their sum 1; the width follows
  Focus focus = Focus::dynamic;
  Steering steering = Steering::true_delay;
  // Response of each element: gain and phase errors, 0 if dead. [elements]
  std::vector<std::complex<double>> response;
};

// Quantizes real and imaginary part of every sample to 2^bits steps over +- full scale.
struct Adc {
  int bits = 16;
  double full_scale_db = 0;  // dB re 1 uPa: the largest |re p| and |im p|
};

// Groups of beams that transmit and listen by themselves: beam j belongs to group j mod count, or
// groups are sectors of neighboring beams. The sound of a group goes out in one lobe about each of
// its beams.
struct TransmitGroups {
  int count = 1;  // divides the number of beams unless groups are sectors
  // Of sectors, [count]: the number of beams of each from starboard on. Empty: j mod count.
  std::vector<int> sector_beams = {};
  std::vector<double> frequency_hz = {};  // carriers, [count]; empty: that of the sonar
  std::vector<int> order = {};            // [count]: the groups as they fire
  double interval_s = 0;                  // from one group to the next
  double width_rad = 0;  // -3 dB of a lobe in azimuth; 0: the receive width of its beam
  std::vector<double> level_db =
      {};                     // [count] or empty: relative to the source level, in all pings
  double level_error_db = 0;  // standard deviation of a group's level in a ping
};

// calibrated: N_j = 1, the sonar equation holds. mean_square: N_j = sqrt(sum |w|^2), Eq 16.
enum class Normalization { calibrated, mean_square };

// per_ping: fresh draws in each ping. per_ray: one pattern, fixed in the sonar's frame. surface:
// scatterers are fixed on the surfaces (trace/surface_points.h).
enum class SpeckleMode { per_ping, per_ray, surface };

struct Sonar {
  double frequency_hz = 0;  // carrier f_c
  double bandwidth_hz = 0;  // b; the sample interval is 1/b
  Pulse pulse;
  Window window = Window::none;
  double source_level_db = 0;  // rms, dB re 1 uPa m
  double range_min_m = 0;      // echoes nearer than this are dropped, the samples stay
  double range_max_m = 0;
  int beam_count = 0;
  double beam_spacing_rad = 0;  // field of view / count; the mean of unequal ones
  // Of beams that are not equally spaced: [beam_count], at least two, rising. Empty: equal spacing.
  std::vector<double> azimuth_rad = {};
  // Of beams that are not equally wide: [beam_count], as beam_width_rad, which is then their mean.
  std::vector<double> width_rad = {};
  double first_range_m = 0;   // of sample 0; only recordings begin later
  double beam_width_rad = 0;  // -3 dB, one-way receive
  BeamShading shading;
  double transmit_width_rad = 0;   // -3 dB, in azimuth about the boresight; 0: uniform
  double elevation_width_rad = 0;  // -3 dB, two-way
  ShadedLine elevation_line;       // of that width; uniform: its aperture is ignored
  double elevation_fan_rad = 0;    // rays span [-fan/2, fan/2]
  int rays_elevation = 0;          // rays per sector
  int rays_azimuth = 1;
  // Least number of scatterers in a resolution cell; 0: no refinement; absent: as many as the
  // expected level and edges need (trace/adaptive.h).
  std::optional<int> rays_per_cell = 0;
  Normalization normalization = Normalization::calibrated;
  std::optional<Detector> detector = {};  // absent: levels are those of |p|^2
  std::optional<ArrayReceiver> array;     // absent: ideal beam cells, mixed by the beam's pattern
  std::optional<Adc> adc;
  std::optional<FrontEnd> front_end = {};       // absent: ideal electronics
  std::optional<TransmitGroups> transmit = {};  // absent: all beams together
};

// Sound speed against depth: linear between the rows, constant beyond the first and the last.
struct SoundProfile {
  double surface_z_m = 0;         // height in the world of depth 0
  std::vector<double> depth_m;    // rising
  std::vector<double> speed_m_s;  // [depth_m]
};

struct Water {
  double sound_speed_m_s = 1500;             // as the instrument assumes it
  double absorption_db_m = 0;                // at the carrier
  std::optional<SoundProfile> profile = {};  // absent: the same speed everywhere
  double density_kg_m3 = 1025;               // for echoes of elastic bodies
  // At the carrier of each group of beams; empty: absorption_db_m.
  std::vector<double> group_absorption_db_m = {};
};

// The words that scenarios and sequence.json use.
const char* name_of(PulseShape shape);
const char* name_of(Window window);
const char* name_of(Shading shading);
const char* name_of(Focus focus);
const char* name_of(Steering steering);
const char* name_of(SpeckleMode speckle);

// The length of a stored record and of the transforms behind it (Eq 10-13).
struct Record {
  int samples = 0;    // N = ceil(b 2R / c)
  int transform = 0;  // M, the smallest even 2-3-5-smooth integer >= N + 64 + ceil(b T_p)
  double sample_interval_s = 0;
};

// Whether all beams have one spacing and one width.
inline bool has_equal_beams(const Sonar& sonar) {
  return sonar.azimuth_rad.empty() && sonar.width_rad.empty();
}

// Azimuth of a beam: theta_j = (j - (count-1)/2) spacing, unless they are given; beam 0 starboard.
double beam_azimuth_rad(const Sonar& sonar, int beam);
std::vector<double> beam_azimuths_rad(const Sonar& sonar);

// Borders of the beam cells, [beams + 1]: halfway between beams, and as far beyond the outer ones.
std::vector<double> beam_borders_rad(const Sonar& sonar);

// Place among the beams, linear between their azimuths: j at that of beam j.
double beam_place(const Sonar& sonar, double azimuth_rad);

// The sector between two borders that holds an azimuth, [theta_j - spacing/2, theta_j + spacing/2);
// none outside.
std::optional<int> sector_of(const Sonar& sonar, double azimuth_rad);

// -3 dB width of a beam, one-way receive.
double width_of_beam_rad(const Sonar& sonar, int beam);

// Angle between the borders of a beam cell, and the smallest of all cells.
double cell_width_rad(const Sonar& sonar, int beam);
// Halfway between its borders: the beam's azimuth if beams are equally spaced.
double cell_middle_rad(const Sonar& sonar, int beam);
double narrowest_cell_rad(const Sonar& sonar);

// The larger |azimuth| of the two ends of the fan.
double furthest_azimuth_rad(const Sonar& sonar);

// The number of groups that transmit by themselves, the group of a beam, and the beams of a group:
// `count` of them from `first` on, `step` apart.
inline int group_count(const Sonar& sonar) { return sonar.transmit ? sonar.transmit->count : 1; }
int group_of(const Sonar& sonar, int beam);
struct GroupBeams {
  int first = 0, step = 1, count = 0;
};
GroupBeams beams_of_group(const Sonar& sonar, int group);

// The time from the ping's transmission to the group's, and the carrier of a group or a beam.
double fired_after_s(const Sonar& sonar, int group);
double carrier_hz(const Sonar& sonar, int group);
inline double carrier_of_beam_hz(const Sonar& sonar, int beam) {
  return carrier_hz(sonar, group_of(sonar, beam));
}

// `pulse_extent_s` is T_p: pulse_extent_s(sonar) of acoustics/pulse.h.
Record make_record(const Sonar& sonar, const Water& water, double pulse_extent_s);

// Slant range of sample n: c n / (2b), after the first range of a recording.
double sample_range_m(const Sonar& sonar, const Water& water, int sample);
// From one sample to the next: c / (2b).
double range_step_m(const Sonar& sonar, const Water& water);

// Smallest even integer >= n whose only prime factors are 2, 3 and 5. Needs n >= 1.
int smooth_even_length(int n);

// S0 = 10^((SL - 120)/20), Pa m.
double source_pressure_pa_m(const Sonar& sonar);

}  // namespace ensonify
