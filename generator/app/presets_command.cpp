#include <fmt/format.h>

#include <cstdio>

#include "app/commands.h"
#include "app/print.h"

namespace ensonify {

Status presets(const std::optional<std::string>& name) {
  std::string names;
  for (const SonarPreset& preset : sonar_presets()) {
    if (name && preset.name == *name) {
      answer("{}", preset.yaml);
      return {};
    }
    names += (names.empty() ? "" : ", ") + preset.name;
  }
  if (name) {
    return Error{ErrorKind::usage, fmt::format("no preset named '{}'; there are {}", *name, names)};
  }
  answer("{:<20} {:>9} {:>9} {:>9} {:>6} {:>7} {:>7}\n", "preset", "f kHz", "b kHz", "fov deg",
         "beams", "width", "range m");
  for (const SonarPreset& preset : sonar_presets()) {
    const auto scenario =
        parse_scenario(fmt::format("ensonify: 1\nname: {0}\nsonar: {{preset: {0}}}\n", preset.name),
                       "preset " + preset.name, ".");
    if (!scenario) return scenario.error();
    const SonarSpec& s = scenario->sonar;
    answer("{:<20} {:>9g} {:>9g} {:>9} {:>6} {:>7g} {:>7g}\n", preset.name, s.frequency_hz / 1e3,
           s.bandwidth_hz / 1e3, fmt::format("{:g}x{:g}", s.beam_fov_deg, s.elevation_width_deg),
           s.beam_count, s.beam_width_deg, s.range_max_m);
  }
  answer("\nensonify presets NAME prints one with its sources.\n");
  return {};
}

}  // namespace ensonify
