// Sound that comes over flat surfaces: what a scenario asks for, and what a sequence says of it.
//
//   FlatSurface  Multipath   which surfaces, and how many bounces
//   SoundPath                one way out and back
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ensonify {

// Horizontal and without end.
struct FlatSurface {
  double z_m = 0;  // in the world
  double reflection = 0;
  double roughness_rms_m = 0;
};

struct Multipath {
  std::optional<FlatSurface> surface;  // sound stays below it
  std::optional<FlatSurface> bottom;
  bool objects = false;  // planes and faces of boxes whose material is kirchhoff
  int bounces = 2;       // at most, out and back together
};

inline constexpr int kMaxBounces = 4;
// How many ways a sequence may have: each is tried for every echo.
inline constexpr std::size_t kMaxSoundPaths = 4096;

// By the names of what it bounces off, in the order of the sound: surface, bottom, OBJECT.z of a
// plane, OBJECT.x- ... OBJECT.z+ of a box's faces. Path 0 is the direct one and not listed.
struct SoundPath {
  std::uint16_t id = 0;  // Scatterer::path
  std::vector<std::string> out, back;
};

}  // namespace ensonify
