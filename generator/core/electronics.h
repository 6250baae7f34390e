// What a receiver's electronics and recorder do to the beams, as plain numbers.
//
//   Leakage  Interference  Saturation  FrontEnd   before the ADC, in Pa
//   Artifact                                      the effects that a mask marks
//   RangeGain  Recorder                           from levels to the counts of a recording
#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/display.h"

namespace ensonify {

// The transmit pulse as the receiver hears it through the housing: noise of this rms level at
// range 0, whose amplitude falls by a factor e every `decay_m`. It is the same in every ping.
struct Leakage {
  double level_db = 0;  // dB re 1 uPa
  double decay_m = 0.1;
};

// Bursts of another sonar in one direction, at its own ping rate.
struct Interference {
  double level_db = 0;  // of the middle of a burst, in a beam that points at it; dB re 1 uPa
  double ping_rate_hz = 0;
  double duration_s = 0;
  double azimuth_rad = 0;
};

// A sample above the limit is clipped, and a tail follows it in its beam: noise whose rms amplitude
// starts at `streak` times the excess and falls by a factor e every `streak_m`.
struct Saturation {
  double level_db = 0;  // dB re 1 uPa
  std::optional<double> streak_db = {};  // absent: no tail
  double streak_m = 1;
};

struct FrontEnd {
  std::vector<std::complex<double>> beam_response = {};  // gain and phase errors; empty: none
  std::optional<double> crosstalk_db = {};  // of the amplitude that each neighboring beam adds
  std::optional<Leakage> leakage = {};
  std::optional<Interference> interference = {};
  double blanking_m = 0;  // the receiver hears nothing from nearer than this
  std::optional<Saturation> saturation = {};
};

// Bits of the mask.
enum class Artifact : std::uint8_t {
  clipped = 1,        // the sample was above the limit of saturation
  streak = 2,         // the tail behind a clipped sample is stronger than the rest
  interference = 4,   // another sonar is
  leakage = 8,        // the leaking pulse is
  blanked = 16,
};

// A gain that follows the level along range: the mean power over the beams of each sample, smoothed
// with these lengths (to 1 - 1/e) while it rises and while it falls, is brought to `level_db`.
struct RangeGain {
  double level_db = 0;
  double attack_m = 0.1, release_m = 1;
  double max_gain_db = 40;
};

// Counts of `bits` bits from the level s of a pixel after its gains:
//   db:         round(m (s - lo)/(hi - lo)), m = 2^bits - 1
//   amplitude:  round(m 10^(gamma (s - hi + row gain)/20))
// both limited to 0 .. m.
struct Recorder {
  int bits = 8;  // 8 or 16
  GreyScale scale = GreyScale::db;
  std::array<double, 2> db = {60, 120};  // lo, hi; dB re 1 uPa
  double gamma = 1;                      // of amplitude
  // Time-varied gain: spreading log10(r / 1 m) + 2 alpha r with absorption, rounded to `step_db`.
  double spreading = 0;
  bool absorption = false;
  double step_db = 0;  // 0: not rounded
  std::optional<RangeGain> range_gain = {};
  double row_gain_db = 0;  // of amplitude: largest gain that brings a sample's peak to m; 0: none
};

}  // namespace ensonify
