#include <type_traits>

#include <fmt/format.h>

#include "scenario/emit.h"

namespace ensonify {
namespace {

std::string kind_text(const VolumeSpec& volume, const NameFile& name_file) {
  return std::visit(
      [&](const auto& s) -> std::string {
        using S = std::decay_t<decltype(s)>;
        if constexpr (std::is_same_v<S, UniformVolumeSpec>) {
          const std::string size = s.size_m ? ", size_m: " + numbers(*s.size_m) : "";
          return fmt::format("uniform: {{strength_db: {}{}}}, extinction_db_m: {}",
                             number(s.strength_db), size, number(s.extinction_db_m));
        } else if constexpr (std::is_same_v<S, VdbVolumeSpec>) {
          return fmt::format("vdb: {{file: {}, grid: {}, strength_db: {}, extinction_db_m: {}}}",
                             quoted_if_needed(name_file(s.file)), quoted_if_needed(s.grid),
                             number(s.strength_db), number(s.extinction_db_m));
        } else if constexpr (std::is_same_v<S, PlumeSpec>) {
          return fmt::format(
              "plume: {{radius_m: {}, height_m: {}, spread_deg: {}, strength_db: {}, "
              "extinction_db_m: {}}}",
              number(s.radius_m), number(s.height_m), number(s.spread_deg), number(s.strength_db),
              number(s.extinction_db_m));
        } else {
          return fmt::format("school: {{size_m: {}, fish: {}, target_strength_db: {}}}",
                             numbers(s.size_m), s.fish, number(s.target_strength_db));
        }
      },
      volume.kind);
}

// What has no end has no place.
bool is_placed(const VolumeSpec& volume) {
  const auto* uniform = std::get_if<UniformVolumeSpec>(&volume.kind);
  return uniform == nullptr || uniform->size_m;
}

}  // namespace

std::string volumes_text(const std::vector<VolumeSpec>& volumes, const NameFile& name_file) {
  if (volumes.empty()) return "volumes: []\n";
  std::string text = "volumes:\n";
  for (const VolumeSpec& volume : volumes) {
    const std::string pose =
        is_placed(volume) ? fmt::format(", pose: {{{}}}", pose_keys(volume.pose)) : "";
    text += fmt::format("  - {{name: {}, class: {}, {}{}}}\n", quoted_if_needed(volume.name),
                        quoted_if_needed(volume.class_name), kind_text(volume, name_file), pose);
  }
  return text;
}

}  // namespace ensonify
