#include <fmt/format.h>

#include "scenario/emit.h"

namespace ensonify {

std::string volumes_text(const std::vector<VolumeSpec>& volumes) {
  if (volumes.empty()) return "volumes: []\n";
  std::string text = "volumes:\n";
  for (const VolumeSpec& volume : volumes) {
    text += fmt::format("  - {{name: {}, class: {}, uniform: {{strength_db: {}}}}}\n",
                        quoted_if_needed(volume.name), quoted_if_needed(volume.class_name),
                        number(volume.strength_db));
  }
  return text;
}

}  // namespace ensonify
