// The keys of the sonar's electronics, detector and recorder.
#include <cmath>

#include <fmt/format.h>

#include "core/part_keys.h"
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

// A number, or a list of two.
void gain_error_field(Fields& f, ElectronicsSpec& electronics) {
  const KeyText text = {
      "beam_gain_error_db", "Gain error",
      "Standard deviation of the gain over the beams, sampled once for the data set, or [fixed, "
      "varying]: the second share is sampled anew in each ping"};
  std::array<double, 2> errors_db = {electronics.beam_gain_error_db,
                                     electronics.front_end.ping_gain_error_db};
  const Node* given = f.peek("beam_gain_error_db");
  const bool is_list = f.writing() ? errors_db[1] > 0 : given && given->kind == NodeKind::list;
  if (is_list ? f.numbers(text, errors_db, kErrorDb) : f.number(text, errors_db[0], kErrorDb)) {
    electronics.beam_gain_error_db = errors_db[0];
    electronics.front_end.ping_gain_error_db = errors_db[1];
  }
}

void count_fields(Fields& f, Recorder& recorder) {
  count_keys(f, recorder);
  if (recorder.bits != 8 && recorder.bits != 16) {
    f.fault("bits", fmt::format("{} bits; expected 8 or 16", recorder.bits));
  }
  if (recorder.db[0] >= recorder.db[1]) {
    f.fault("db", fmt::format("the first level, {} dB, is not below the second, {} dB; expected "
                              "[low, high] with low below high",
                              recorder.db[0], recorder.db[1]));
  }
  const bool useless = recorder.scale == GreyScale::db;
  const Rule of_amplitude = useless_if(
      useless, "with scale: db (the default); expected scale: amplitude", written_if(!useless));
  gamma_key(f, recorder, of_amplitude);
  row_gain_key(f, recorder, of_amplitude);
}

void tvg_fields(Fields& f, Recorder& recorder) {
  if (!f.begin({"tvg", "Time-varied gain", "Gain that increases with range; left out: none"},
               written_if(recorder.spreading > 0 || recorder.absorption, {.has_default = false}))) {
    return;
  }
  tvg_keys(f, recorder);
  f.end();
}

}  // namespace

void fields(Fields& f, ElectronicsSpec& electronics) {
  gain_error_field(f, electronics);
  f.number({"beam_phase_error_deg", "Phase error",
            "Standard deviation of the phase over the beams, sampled once for the data set"},
           electronics.beam_phase_error_deg, kErrorDeg);
  front_end_keys(f, electronics.front_end, [&](Fields& other, const Interference& values) {
    azimuth_field(other, values, electronics.interference_azimuth_deg);
  });
}

void fields(Fields& f, Detector& detector) {
  detector_keys(f, detector);
  if (detector.integrate == 1 && detector.law != DetectorLaw::power) {
    f.fault("law", fmt::format("{} has no effect on single samples; expected it with integrate "
                               "above 1",
                               name_of(detector.law)));
  }
}

void check_detector(Faults& faults, const Value& root, const Scenario& scenario) {
  const auto value = child(root, "sonar");
  const auto& detector = scenario.sonar.detector;
  if (!value || !detector) return;
  // The keys may come from a preset, which is not in this tree.
  const auto map = child(*value, "detector");
  const auto refuse = [&](const std::optional<Value>& key, std::string text) {
    const Value& culprit = key ? *key : map ? *map : *value;
    add_fault(faults, culprit.place, culprit.path, std::move(text));
  };
  const SonarSpec& sonar = scenario.sonar;
  const double samples =
      std::ceil(sonar.bandwidth_hz * 2 * sonar.range_max_m / scenario.water.sound_speed_m_s);
  if (samples > 0 && detector->integrate > samples) {
    refuse(map ? child(*map, "integrate") : map,
           fmt::format("{:g} samples are more than the {} of the record; expected at most these",
                       detector->integrate, samples));
  }
  const OutputSelection& output = scenario.output.selection;
  if (output.statistics && !output.pings) {
    refuse(map,
           "has no effect on output.statistics, which are those of the time series before it; "
           "expected output.pings: true, whose images have its levels, or no detector");
  }
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
