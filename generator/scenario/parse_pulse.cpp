#include <fmt/format.h>

#include "scenario/parse.h"

namespace ensonify {
namespace {

constexpr NumberRange kDuration = above_up_to(0, 100);
constexpr NumberRange kTaper = above_up_to(0, 0.5);

// `1.0` in a file is rounded: a product that ought to be one may fall short of it by this.
constexpr double kRounding = 1e-9;

struct PulseName {
  std::string_view word;
  PulseShape shape;
};
constexpr PulseName kPulses[] = {{"gaussian", PulseShape::gaussian},
                                 {"flat", PulseShape::flat},
                                 {"lfm", PulseShape::lfm},
                                 {"cw", PulseShape::cw},
                                 {"table", PulseShape::table}};

// The value of the pulse's duration, if it has one.
std::optional<Value> duration_in(const Value& sonar) {
  const auto pulse = child(sonar, "pulse");
  if (!pulse) return std::nullopt;
  for (const char* word : {"lfm", "cw"}) {
    if (const auto options = child(*pulse, word)) return child(*options, "duration_s");
  }
  return std::nullopt;
}

}  // namespace

void parse_pulse(const InputFolder& input, const Value& sonar, PulseSpec& pulse) {
  Faults& faults = input.faults;
  std::vector<std::string_view> words;
  for (const PulseName& name : kPulses) words.push_back(name.word);
  const auto kind = read_kind(faults, sonar, "pulse", words);
  if (!kind) return;
  for (const PulseName& name : kPulses) {
    if (name.word == kind->word) pulse.shape = name.shape;
  }
  const Value& options = kind->options;
  switch (pulse.shape) {
    case PulseShape::gaussian:
    case PulseShape::flat:
      open_map(faults, options, {});
      return;
    case PulseShape::lfm:
      if (!open_map(faults, options, {"duration_s", "taper"})) return;
      read_number(faults, options, "duration_s", kDuration, pulse.duration_s, Need::required);
      read_number(faults, options, "taper", kTaper, pulse.taper);
      return;
    case PulseShape::cw:
      if (!open_map(faults, options, {"duration_s"})) return;
      read_number(faults, options, "duration_s", kDuration, pulse.duration_s, Need::required);
      return;
    case PulseShape::table:
      if (!open_map(faults, options, {"file"})) return;
      parse_input_file(input, options, "file", {".csv"}, pulse.file);
      return;
  }
}

void check_pulse_band(Faults& faults, const Value& sonar_value, const SonarSpec& sonar) {
  const auto duration = duration_in(sonar_value);
  const auto bandwidth = child(sonar_value, "bandwidth_hz");
  const double duration_s = sonar.pulse.duration_s;
  if (!duration || !bandwidth || duration_s == 0 || sonar.bandwidth_hz == 0) return;
  if (duration_s * sonar.bandwidth_hz >= 1 - kRounding) return;
  const Value culprit = blamed(*duration, *bandwidth);
  const std::string_view trouble = sonar.pulse.shape == PulseShape::cw
                                       ? "a burst this short is wider than the band"
                                       : "a chirp this short has nothing to compress";
  add_fault(faults, culprit.place, culprit.path,
            fmt::format("duration_s {} times bandwidth_hz {} is {:.3g}: {}, accepted is a product "
                        "of at least 1",
                        duration_s, sonar.bandwidth_hz, duration_s * sonar.bandwidth_hz, trouble));
}

void check_burst_length(Faults& faults, const Value& root, const Scenario& scenario) {
  const SonarSpec& sonar = scenario.sonar;
  const auto value = child(root, "sonar");
  if (!value || sonar.pulse.shape != PulseShape::cw || sonar.range_max_m == 0) return;
  const double record_s = 2 * sonar.range_max_m / scenario.water.sound_speed_m_s;
  if (sonar.pulse.duration_s <= record_s * (1 + kRounding)) return;
  // The duration may come from a preset, which is not in this tree.
  const auto duration = duration_in(*value);
  const Value& culprit = duration ? *duration : *value;
  add_fault(faults, culprit.place, culprit.path,
            fmt::format("a burst of {} s is longer than the record of {:.4g} s (2 range_max_m / "
                        "sound speed), accepted is a shorter one",
                        sonar.pulse.duration_s, record_s));
}

}  // namespace ensonify
