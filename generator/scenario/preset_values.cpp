#include "scenario/preset_values.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "acoustics/pattern.h"
#include "core/error.h"
#include "core/units.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

const Node* find_in(const Node& map, std::string_view section, std::string_view key) {
  const Node* inner = map.kind == NodeKind::map ? find(map, section) : nullptr;
  return inner != nullptr && inner->kind == NodeKind::map ? find(*inner, key) : nullptr;
}

// Of a key that every preset has.
double preset_number(const PresetKeys& keys, std::string_view section, std::string_view key) {
  const Node* inner = find(keys.preset, section);
  ENSONIFY_ASSERT(inner != nullptr);
  const auto value = number_in(*inner, key);
  ENSONIFY_ASSERT(value);
  return *value;
}

// Whether the scenario has changed the pattern in elevation of the preset.
bool has_other_pattern(const PresetKeys& keys, const SonarSpec& sonar) {
  const Node* shading = find_in(keys.preset, "elevation", "shading");
  const std::string own = shading != nullptr ? shading->text : "uniform";
  return sonar.elevation_width_deg != preset_number(keys, "elevation", "width_deg") ||
         name_of(sonar.elevation_shading.kind) != own;
}

// The angle between the first zeros of the pattern, rounded down like those of the presets.
double fan_to_zeros_deg(const SonarSpec& sonar) {
  const ShadedLine line =
      make_shaded_line(sonar.elevation_shading, radians(sonar.elevation_width_deg));
  return std::min(180.0, std::floor(20 * degrees(first_zero_rad(line))) / 10);
}

// What follows from a change of the preset's pattern, unless the scenario sets the fan: it ends
// where that of the preset does, at the first zeros of the pattern or at its width. If it is wider
// than that of the preset, it keeps the density of the rays.
void follow_pattern(const PresetKeys& keys, SonarSpec& sonar) {
  const bool is_given = find_in(*keys.given, "elevation", "fan_deg") != nullptr;
  if (is_given || !has_other_pattern(keys, sonar)) return;
  const double width_deg = preset_number(keys, "elevation", "width_deg");
  const double fan_deg = number_in(*find(keys.preset, "elevation"), "fan_deg").value_or(width_deg);
  const bool is_at_width = fan_deg == width_deg;
  sonar.elevation_fan_deg = is_at_width ? sonar.elevation_width_deg : fan_to_zeros_deg(sonar);
  const double wider = sonar.elevation_fan_deg / fan_deg;
  if (wider <= 1 || find_in(*keys.given, "rays", "elevation") != nullptr) return;
  const double rays = std::round(preset_number(keys, "rays", "elevation") * wider);
  sonar.rays_elevation = static_cast<int>(std::min<double>(rays, kMaxRays));
}

// Widths, level and bandwidth of a preset are those at its frequency.
constexpr double kSameFrequency = 0.05;

void notice_frequency(const PresetKeys& keys, SonarSpec& sonar) {
  const auto own_hz = number_in(keys.preset, "frequency_hz");
  ENSONIFY_ASSERT(own_hz);
  if (std::abs(sonar.frequency_hz / *own_hz - 1) <= kSameFrequency) return;
  const bool has_azimuth = find_in(*keys.given, "beams", "receive_width_deg") != nullptr ||
                           find_in(*keys.given, "beams", "receive_widths_deg") != nullptr;
  const bool has_elevation = find_in(*keys.given, "elevation", "width_deg") != nullptr;
  if (has_azimuth && has_elevation) return;
  const double scale = *own_hz / sonar.frequency_hz;
  std::string widths;
  if (!has_azimuth) {
    widths = fmt::format("beams.receive_width_deg {:.3g} (its aperture would have {:.3g})",
                         sonar.beam_width_deg, scale * sonar.beam_width_deg);
  }
  if (!has_elevation) {
    widths += fmt::format("{}elevation.width_deg {:.3g} (its aperture would have {:.3g})",
                          widths.empty() ? "" : " and ", sonar.elevation_width_deg,
                          scale * sonar.elevation_width_deg);
  }
  sonar.notices.push_back(fmt::format(
      "sonar.frequency_hz: {:g} is not the {:g} of preset {}, whose other values stay: {}; give "
      "them, and source_level_db and bandwidth_hz if they differ at this frequency",
      sonar.frequency_hz, *own_hz, keys.name, widths));
}

}  // namespace

void follow_preset(const PresetKeys& keys, SonarSpec& sonar) {
  follow_pattern(keys, sonar);
  notice_frequency(keys, sonar);
}

}  // namespace ensonify
