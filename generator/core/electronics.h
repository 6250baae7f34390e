// What a receiver's electronics and recorder do to the beams, as plain numbers.
//
//   Leakage  Interference  Saturation  FrontEnd   before the ADC, in Pa
//   Artifact  leaves_marks                        the effects that a mask marks
//   RangeGain  Recorder                           from levels to the counts of a recording
//   front_end_keys  range_gain_keys               their keys (core/keys.h)
#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/display.h"
#include "core/keys.h"

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
  double ping_gain_error_db = 0;  // standard deviation of what a beam's gain adds in each ping
  // Of the amplitude that beams j - kG and j + kG add to beam j, k = 1, 2 ..., with G groups of
  // beams that transmit in turn, or G = 1.
  OneOrMore crosstalk_db = {};
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

// Whether an effect can leave marks in the mask. The effect of each artifact belongs here.
inline bool leaves_marks(const FrontEnd& front) {
  return front.leakage || front.interference || front.blanking_m > 0 || front.saturation;
}

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

inline constexpr NumberRange kShareDb = from_to(-200, 0);
inline constexpr NumberRange kGainDb = from_to(0, 200);
inline constexpr const char* kPressure = "dB re 1 µPa";

template <class Io, class Values>
void leakage_keys(Io& io, Values& leakage) {
  io.number({"level_db", "Level", "Rms level at range 0", kPressure}, leakage.level_db, kLevelDb,
            kRequired);
  io.number({"decay_m", "Decay", "Range over which the amplitude falls by a factor e"},
            leakage.decay_m, kLength);
}

template <class Io, class Values>
void interference_keys(Io& io, Values& other) {
  io.number(
      {"level_db", "Level", "Level of a burst in a beam that points at the other sonar", kPressure},
      other.level_db, kLevelDb, kRequired);
  io.number({"ping_rate_hz", "Ping rate", "Ping rate of the other sonar"}, other.ping_rate_hz,
            above_up_to(0, 1000), kRequired);
  io.number(
      {"duration_s", "Duration", "Duration of a burst; its product with ping_rate_hz is at most 1"},
      other.duration_s, above_up_to(0, 100), kRequired);
}

template <class Io, class Values>
void saturation_keys(Io& io, Values& saturation) {
  io.number({"level_db", "Limit", "Level at which a sample is clipped", kPressure},
            saturation.level_db, kLevelDb, kRequired);
  io.number({"streak_db", "Streak",
             "Rms amplitude of the tail behind a clipped sample, relative to the amplitude by "
             "which the sample exceeds the limit; left out: no tail",
             "dB"},
            saturation.streak_db, kShareDb);
  io.number({"streak_m", "Length of the streak",
             "Range over which the tail's amplitude falls by a factor e"},
            saturation.streak_m, kLength);
}

// `azimuth(io, interference)` ends the keys of an interference: degrees in scenarios, radians in
// files.
template <class Io, class Values, class Azimuth>
void front_end_keys(Io& io, Values& front, Azimuth azimuth) {
  io.number({"crosstalk_db", "Cross-talk",
             "Amplitude that each beam adds to its two neighbors, relative to its own, or a list: "
             "number k applies to the beams k places away, with sonar.transmit k times as many "
             "places as there are groups; left out: none",
             "dB"},
            front.crosstalk_db, kShareDb);
  io.part({"leakage", "Transmit leakage",
           "The transmit pulse as the receiver hears it through the housing, the same noise in "
           "every ping; left out: none"},
          front.leakage, [](Io& part, auto& leakage) { leakage_keys(part, leakage); });
  io.part({"interference", "Interference",
           "Bursts of another sonar, lines across the beams at the range of their arrival; left "
           "out: none"},
          front.interference, [&](Io& part, auto& other) {
            interference_keys(part, other);
            azimuth(part, other);
          });
  io.number({"blanking_m", "Blanking", "Range up to which the receiver is switched off"},
            front.blanking_m, from_to(0, kMaxLengthM));
  io.part({"saturation", "Saturation",
           "Limit of the receiver's amplitude, and the tail behind what exceeds it; left out: "
           "none"},
          front.saturation, [](Io& part, auto& saturation) { saturation_keys(part, saturation); });
}

template <class Io, class Values>
void range_gain_keys(Io& io, Values& gain) {
  io.number({"level_db", "Level", "Level that the gain brings the mean power to", kPressure},
            gain.level_db, kLevelDb, kRequired);
  io.number({"attack_m", "Attack", "Smoothing length while the power rises"}, gain.attack_m,
            kLength);
  io.number({"release_m", "Release", "Smoothing length while the power falls"}, gain.release_m,
            kLength);
  io.number({"max_gain_db", "Largest gain", "Limit of the gain"}, gain.max_gain_db, kGainDb);
}

}  // namespace ensonify
