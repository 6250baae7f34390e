// Scattering and attenuation in the water itself, as a scenario describes it.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "core/surface.h"
#include "scenario/path_spec.h"

namespace ensonify {

// All the water, or a box centered at the volume's origin.
struct UniformVolumeSpec {
  double strength_db = 0;  // dB re 1/m
  std::optional<std::array<double, 3>> size_m;
  double extinction_db_m = 0;                  // one way
  std::optional<SurfaceTexture> patches = {};  // factor on the density; absent: even
};

// Strength and extinction are those of density 1; both are proportional to the density.
struct VdbVolumeSpec {
  std::filesystem::path file;
  std::string grid = "density";
  double strength_db = 0;
  double extinction_db_m = 0;
};

// Rises from a disc at the volume's origin along z. Strength and extinction are the means on the
// axis at the foot.
struct PlumeSpec {
  double radius_m = 0;    // at the foot
  double height_m = 0;    // at most kMaxPlumeSlimness times the radius
  double spread_deg = 5;  // angle between axis and rim
  double strength_db = 0;
  double extinction_db_m = 0;
};
inline constexpr double kMaxPlumeSlimness = 1000;

// Fish at rest, randomly placed in an ellipsoid with these axes around the volume's origin.
struct SchoolSpec {
  std::array<double, 3> size_m{};
  int fish = 0;
  double target_strength_db = 0;  // of one fish
};
inline constexpr int kMaxFish = 100'000;

using VolumeKindSpec = std::variant<UniformVolumeSpec, VdbVolumeSpec, PlumeSpec, SchoolSpec>;

// Name and kind are required.
struct VolumeSpec {
  std::string name;
  std::string class_name = "volume";
  VolumeKindSpec kind;
  PoseSpec pose;  // without effect for an infinite uniform volume
};

}  // namespace ensonify
