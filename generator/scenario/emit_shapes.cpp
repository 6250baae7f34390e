#include <type_traits>

#include <fmt/format.h>

#include "scenario/emit.h"

namespace ensonify {
namespace {

std::string parts_text(const std::vector<PartSpec>& parts) {
  if (parts.empty()) return "";
  std::string text;
  for (const PartSpec& part : parts) {
    text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", quoted_if_needed(part.part),
                        quoted_if_needed(part.material));
  }
  return ", parts: {" + text + "}";
}

}  // namespace

std::string shape_text(const ShapeSpec& shape, const NameFile& name_file) {
  return std::visit(
      [&](const auto& s) -> std::string {
        using S = std::decay_t<decltype(s)>;
        if constexpr (std::is_same_v<S, BoxSpec>) {
          return fmt::format("box: {{size_m: {}, inside: {}}}", numbers(s.size_m), s.inside);
        } else if constexpr (std::is_same_v<S, SphereSpec>) {
          return fmt::format("sphere: {{radius_m: {}, inside: {}}}", number(s.radius_m), s.inside);
        } else if constexpr (std::is_same_v<S, CylinderSpec>) {
          return fmt::format("cylinder: {{radius_m: {}, height_m: {}}}", number(s.radius_m),
                             number(s.height_m));
        } else if constexpr (std::is_same_v<S, PlaneSpec>) {
          return "plane: {}";
        } else if constexpr (std::is_same_v<S, HeightfieldSpec>) {
          return heightfield_text(s, name_file);
        } else if constexpr (std::is_same_v<S, ModelSpec>) {
          return fmt::format("model: {{kind: {}, size_m: {}}}", word_of(s.kind), number(s.size_m));
        } else if constexpr (std::is_same_v<S, LevelSetSpec>) {
          const std::string grid = s.grid.empty() ? "" : ", grid: " + quoted_if_needed(s.grid);
          return fmt::format("level_set: {{file: {}{}, normals: {}}}",
                             quoted_if_needed(name_file(s.file)), grid,
                             s.smooth_normals ? "smooth" : "face");
        } else {
          return fmt::format("mesh: {{file: {}, scale: {}, normals: {}, reflectivity: {}{}}}",
                             quoted_if_needed(name_file(s.file)), number(s.scale),
                             s.smooth_normals ? "smooth" : "face",
                             s.vertex_reflectivity ? "vertex_color" : "material",
                             parts_text(s.parts));
        }
      },
      shape);
}

}  // namespace ensonify
