// Everyday objects as built-in shapes: shape: {model: {kind: tyre, size_m: 0.6}}.
#pragma once

#include <array>
#include <string_view>
#include <utility>

namespace ensonify {

enum class ModelKind {
  bottle,
  can,
  tyre,
  chain,
  hook,
  propeller,
  valve,
  carton,
  shackle,
  wall,
  pipe,
  crab_pot,
  ladder,
  net,
};

// Both are required. The size is the longest edge of the bounding box.
struct ModelSpec {
  ModelKind kind = ModelKind::bottle;
  double size_m = 0;
};

// In the order of ModelKind.
inline constexpr std::array<std::pair<std::string_view, ModelKind>, 14> kModelKinds = {{
    {"bottle", ModelKind::bottle},
    {"can", ModelKind::can},
    {"tyre", ModelKind::tyre},
    {"chain", ModelKind::chain},
    {"hook", ModelKind::hook},
    {"propeller", ModelKind::propeller},
    {"valve", ModelKind::valve},
    {"carton", ModelKind::carton},
    {"shackle", ModelKind::shackle},
    {"wall", ModelKind::wall},
    {"pipe", ModelKind::pipe},
    {"crab_pot", ModelKind::crab_pot},
    {"ladder", ModelKind::ladder},
    {"net", ModelKind::net},
}};

constexpr std::string_view word_of(ModelKind kind) {
  return kModelKinds[static_cast<std::size_t>(kind)].first;
}

}  // namespace ensonify
