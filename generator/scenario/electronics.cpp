// The keys of the sonar's electronics and recorder.
#include <fmt/format.h>

#include "core/units.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

constexpr NumberRange kErrorDb = from_to(0, 40);
constexpr NumberRange kErrorDeg = from_to(0, 360);
constexpr NumberRange kAzimuth = from_to(-180, 180);

// Ends the keys of an interference.
void azimuth_field(Fields& f, const Interference& other, double& azimuth_deg) {
  f.number({"azimuth_deg", "Azimuth", "Azimuth of the other sonar; positive to port"}, azimuth_deg,
           kAzimuth);
  if (other.ping_rate_hz * other.duration_s > 1) {
    f.fault("duration_s", fmt::format("bursts of {} s at {} per second overlap; expected a product "
                                      "of ping_rate_hz and duration_s of at most 1",
                                      other.duration_s, other.ping_rate_hz));
  }
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
  front_end_keys(f, electronics.front_end, [&](Fields& other, const Interference& values) {
    azimuth_field(other, values, electronics.interference_azimuth_deg);
  });
}

void fields(Fields& f, RecorderSpec& spec) {
  count_fields(f, spec.recorder);
  tvg_fields(f, spec.recorder);
  f.part({"range_gain", "Automatic gain along range",
          "Gain that brings the mean power over the beams, smoothed along range, to a level; left "
          "out: none"},
         spec.recorder.range_gain, [](Fields& io, RangeGain& gain) { range_gain_keys(io, gain); });
  f.number({"dropped", "Dropped frames",
            "Probability that a frame is not recorded: the next ping follows one or more periods "
            "later; with trajectory.pings, the number of pings stays"},
           spec.dropped, from_to(0, 0.9));
}

}  // namespace ensonify
