// The keys of the sonar's electronics and recorder.
#include <fmt/format.h>

#include "core/units.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

constexpr NumberRange kErrorDb = from_to(0, 40);
constexpr NumberRange kErrorDeg = from_to(0, 360);
constexpr NumberRange kShareDb = from_to(-200, 0);
constexpr NumberRange kRate = above_up_to(0, 1000);
constexpr NumberRange kSeconds = above_up_to(0, 100);
constexpr NumberRange kAzimuth = from_to(-180, 180);
constexpr NumberRange kGainDb = from_to(0, 200);
constexpr const char* kPressure = "dB re 1 µPa";

void leakage_fields(Fields& f, std::optional<Leakage>& given) {
  if (!f.begin({"leakage", "Transmit leakage",
                "The transmit pulse as the receiver hears it through the housing, the same noise "
                "in every ping; left out: none"},
               written_if(given.has_value(), {.has_default = given.has_value()}))) {
    return;
  }
  Leakage leakage = given.value_or(Leakage{});
  f.number({"level_db", "Level", "Rms level at range 0", kPressure}, leakage.level_db, kLevelDb,
           kRequired);
  f.number({"decay_m", "Decay", "Range over which the amplitude falls by a factor e"},
           leakage.decay_m, kLength);
  given = leakage;
  f.end();
}

void interference_fields(Fields& f, std::optional<Interference>& given, double& azimuth_deg) {
  if (!f.begin({"interference", "Interference",
                "Bursts of another sonar, lines across the beams at the range of their arrival; "
                "left out: none"},
               written_if(given.has_value(), {.has_default = given.has_value()}))) {
    return;
  }
  Interference other = given.value_or(Interference{});
  f.number(
      {"level_db", "Level", "Level of a burst in a beam that points at the other sonar", kPressure},
      other.level_db, kLevelDb, kRequired);
  f.number({"ping_rate_hz", "Ping rate", "Ping rate of the other sonar"}, other.ping_rate_hz, kRate,
           kRequired);
  f.number(
      {"duration_s", "Duration", "Duration of a burst; its product with ping_rate_hz is at most 1"},
      other.duration_s, kSeconds, kRequired);
  f.number({"azimuth_deg", "Azimuth", "Azimuth of the other sonar; positive to port"}, azimuth_deg,
           kAzimuth);
  if (other.ping_rate_hz * other.duration_s > 1) {
    f.fault("duration_s", fmt::format("bursts of {} s at {} per second overlap; expected a product "
                                      "of ping_rate_hz and duration_s of at most 1",
                                      other.duration_s, other.ping_rate_hz));
  }
  given = other;
  f.end();
}

void saturation_fields(Fields& f, std::optional<Saturation>& given) {
  if (!f.begin({"saturation", "Saturation",
                "Limit of the receiver's amplitude, and the tail behind what exceeds it; left "
                "out: none"},
               written_if(given.has_value(), {.has_default = given.has_value()}))) {
    return;
  }
  Saturation saturation = given.value_or(Saturation{});
  f.number({"level_db", "Limit", "Level at which a sample is clipped", kPressure},
           saturation.level_db, kLevelDb, kRequired);
  f.number({"streak_db", "Streak",
            "Rms amplitude of the tail behind a clipped sample, relative to the amplitude by which "
            "the sample exceeds the limit; left out: no tail",
            "dB"},
           saturation.streak_db, kShareDb);
  f.number({"streak_m", "Length of the streak",
            "Range over which the tail's amplitude falls by a factor e"},
           saturation.streak_m, kLength);
  given = saturation;
  f.end();
}

void range_gain_fields(Fields& f, std::optional<RangeGain>& given) {
  if (!f.begin({"range_gain", "Automatic gain along range",
                "Gain that brings the mean power over the beams, smoothed along range, to a level; "
                "left out: none"},
               written_if(given.has_value(), {.has_default = given.has_value()}))) {
    return;
  }
  RangeGain gain = given.value_or(RangeGain{});
  f.number({"level_db", "Level", "Level that the gain brings the mean power to", kPressure},
           gain.level_db, kLevelDb, kRequired);
  f.number({"attack_m", "Attack", "Smoothing length while the power rises"}, gain.attack_m,
           kLength);
  f.number({"release_m", "Release", "Smoothing length while the power falls"}, gain.release_m,
           kLength);
  f.number({"max_gain_db", "Largest gain", "Limit of the gain"}, gain.max_gain_db, kGainDb);
  given = gain;
  f.end();
}

void count_fields(Fields& f, Recorder& recorder) {
  f.integer({"bits", "Bits", "Bits of a count, which is between 0 and 2^bits - 1; 8 or 16"},
            recorder.bits, 8, 16);
  if (recorder.bits != 8 && recorder.bits != 16) {
    f.fault("bits", fmt::format("{} bits; expected 8 or 16", recorder.bits));
  }
  f.choice<GreyScale>({"scale", "Scale",
                       "db: counts are linear in dB between the limits; amplitude: they are "
                       "proportional to a power of the amplitude"},
                      recorder.scale, {{"db", GreyScale::db}, {"amplitude", GreyScale::amplitude}});
  const bool limited =
      f.numbers({"db", "Limits",
                 "[low, high]: levels with gain of count 0 and of the largest count; low has no "
                 "effect with scale amplitude",
                 kPressure},
                recorder.db, kLevelDb, kRequired);
  if (limited && recorder.db[0] >= recorder.db[1]) {
    f.fault("db", fmt::format("the first level, {} dB, is not below the second, {} dB; expected "
                              "[low, high] with low below high",
                              recorder.db[0], recorder.db[1]));
  }
  const bool useless = recorder.scale == GreyScale::db;
  const Rule of_amplitude = useless_if(
      useless, "with scale: db (the default); expected scale: amplitude", written_if(!useless));
  f.number({"gamma", "Gamma", "Power of the amplitude that counts are proportional to"},
           recorder.gamma, above_up_to(0, 20), of_amplitude);
  f.number({"row_gain_db", "Row gain",
            "Largest gain that brings the strongest echo of a sample, over all beams, to the "
            "largest count; it is stored; 0: none"},
           recorder.row_gain_db, kGainDb, of_amplitude);
}

void tvg_fields(Fields& f, Recorder& recorder) {
  if (!f.begin({"tvg", "Time-varied gain", "Gain that increases with range; left out: none"},
               written_if(recorder.spreading > 0 || recorder.absorption, {.has_default = false}))) {
    return;
  }
  f.number({"spreading", "Spreading", "Gain for each tenfold of range", "dB per tenfold of range"},
           recorder.spreading, from_to(0, 100));
  f.boolean({"absorption", "Absorption",
             "Whether the gain compensates the two-way absorption of the water"},
            recorder.absorption);
  f.number({"step_db", "Step", "Step to which the gain is rounded; 0: not rounded"},
           recorder.step_db, kGainDb);
  f.end();
}

}  // namespace

void fields(Fields& f, ElectronicsSpec& electronics) {
  f.number({"beam_gain_error_db", "Gain error",
            "Standard deviation of the gain over the beams, sampled once for the data set"},
           electronics.beam_gain_error_db, kErrorDb);
  f.number({"beam_phase_error_deg", "Phase error",
            "Standard deviation of the phase over the beams, sampled once for the data set"},
           electronics.beam_phase_error_deg, kErrorDeg);
  FrontEnd& front = electronics.front_end;
  f.number({"crosstalk_db", "Cross-talk",
            "Amplitude that each beam adds to its two neighbors, relative to its own; left out: "
            "none",
            "dB"},
           front.crosstalk_db, kShareDb);
  leakage_fields(f, front.leakage);
  interference_fields(f, front.interference, electronics.interference_azimuth_deg);
  f.number({"blanking_m", "Blanking", "Range up to which the receiver is switched off"},
           front.blanking_m, from_to(0, kMaxLengthM));
  saturation_fields(f, front.saturation);
}

void fields(Fields& f, RecorderSpec& spec) {
  count_fields(f, spec.recorder);
  tvg_fields(f, spec.recorder);
  range_gain_fields(f, spec.recorder.range_gain);
  f.number({"dropped", "Dropped frames",
            "Probability that a frame is not recorded: the next ping follows one or more periods "
            "later; with trajectory.pings, the number of pings stays"},
           spec.dropped, from_to(0, 0.9));
}

}  // namespace ensonify
