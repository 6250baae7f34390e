// The keys of a camera.
//
//   CameraSpec  CameraWaterSpec
//   optics_of  water_of   numbers that follow
#pragma once

#include <array>
#include <optional>

#include "core/camera.h"
#include "core/keys.h"
#include "scenario/path_spec.h"

namespace ensonify {

// Of a Jerlov type, or of attenuations. Absent values follow: water_of.
struct CameraWaterSpec {
  std::optional<std::size_t> jerlov;  // in kJerlovTypes
  std::optional<Rgb> attenuation_per_m, backscatter_per_m, veil;
};

// One of fov_deg and focal_px is required.
struct CameraSpec {
  PoseSpec mount;  // on the body; x along the axis of view, y to the left of the image, z up
  int width_px = 640, height_px = 480;
  std::optional<double> fov_deg;                   // of the width, without distortion
  OneOrMore focal_px;                              // one number, or those along x and y
  std::optional<std::array<double, 2>> center_px;  // absent: the middle of the image
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
  double range_max_m = 100;
  int samples = 1;
  CameraLight light;                     // without surface_z_m
  std::optional<CameraWaterSpec> water;  // absent: clear
  std::optional<double> surface_z_m;     // absent: that of multipath.surface or water.profile
};

CameraOptics optics_of(const CameraSpec& spec);

// Left out, backscatter_per_m is attenuation_per_m, and the veil is kVeil in the clearest of the
// colors and in inverse proportion to the attenuation in the others, as if the water scattered all
// colors alike.
CameraWater water_of(const CameraWaterSpec& spec);
inline constexpr double kVeil = 0.2;

}  // namespace ensonify
