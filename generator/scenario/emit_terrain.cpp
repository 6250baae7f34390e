#include <fmt/format.h>

#include "scenario/emit.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

std::string made_keys(const HeightfieldSpec& field) {
  std::string text =
      fmt::format("size_m: {}, cell_m: {}", numbers(field.size_m), number(field.cell_m));
  if (const auto& roughness = field.roughness) {
    text += fmt::format(", roughness: {{rms_m: {}, exponent: {}, outer_scale_m: {}}}",
                        number(roughness->rms_m), number(roughness->exponent),
                        number(roughness->outer_scale_m));
  }
  if (field.ripples.empty()) return text;
  text += ", ripples: [";
  for (std::size_t i = 0; i < field.ripples.size(); ++i) {
    const RippleSpec& ripple = field.ripples[i];
    text += fmt::format("{}{{height_m: {}, wavelength_m: {}, direction_deg: {}}}",
                        i == 0 ? "" : ", ", number(ripple.height_m), number(ripple.wavelength_m),
                        number(ripple.direction_deg));
  }
  return text + "]";
}

std::string file_keys(const HeightfieldSpec& field, const NameFile& name_file) {
  std::string text = "file: " + quoted_if_needed(name_file(field.file));
  if (!equals_ignoring_case(field.file.extension().string(), ".asc")) {
    text += ", cell_m: " + number(field.cell_m);
  }
  return text + fmt::format(", height_scale: {}, height_offset_m: {}", number(field.height_scale),
                            number(field.height_offset_m));
}

}  // namespace

std::string heightfield_text(const HeightfieldSpec& field, const NameFile& name_file) {
  std::string text = field.file.empty() ? made_keys(field) : file_keys(field, name_file);
  text += std::string(", normals: ") + (field.smooth_normals ? "smooth" : "face");
  if (!field.reflectivity_map.empty()) {
    text += ", reflectivity_map: " + quoted_if_needed(name_file(field.reflectivity_map));
  }
  return "heightfield: {" + text + "}";
}

}  // namespace ensonify
