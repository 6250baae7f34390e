// A camera: how points project onto its pixels, and what its images depend on besides the world.
//
//   CameraOptics   distorted  undistorted  projected  pixel_direction  unseen_pixel
//   Rgb  CameraLight  CameraWater  JerlovType  kJerlovTypes  Camera
//
// Frames: x to the right of the image, y down, z along the axis of view, as in OpenCV. Pixel
// (u, v) = (0, 0) is the center of the first pixel of the top row.
#pragma once

#include <array>
#include <optional>

#include "core/vec.h"

namespace ensonify {

// u = focal_x_px x'' + center_x_px and v = focal_y_px y'' + center_y_px, where (x'', y'') is
// distorted(x / z, y / z).
struct CameraOptics {
  int width_px = 640, height_px = 480;
  double focal_x_px = 0, focal_y_px = 0;
  double center_x_px = 0, center_y_px = 0;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  bool is_distorted() const { return k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0 || k3 != 0; }
};

// A point of the image plane at z = 1.
struct ImagePoint {
  double x = 0, y = 0;
};

// With r^2 = x^2 + y^2 and s = 1 + k1 r^2 + k2 r^4 + k3 r^6 (Brown 1966, as OpenCV writes it):
//   x'' = s x + 2 p1 x y + p2 (r^2 + 2 x^2),  y'' = s y + p1 (r^2 + 2 y^2) + 2 p2 x y
ImagePoint distorted(const CameraOptics& optics, ImagePoint p);

// The inverse, followed from the axis outward, to 1e-12. None if the distortion folds the image
// before it reaches the point: then it has no inverse there.
std::optional<ImagePoint> undistorted(const CameraOptics& optics, ImagePoint p);

// Where a point of the camera's frame is in the image, in pixels; inside the image or not. None for
// a point that is not in front of the camera, or so far aside that the distortion has no inverse.
std::optional<ImagePoint> projected(const CameraOptics& optics, Vec3 point_m);

// (x, y, 1) of the points that a place in the image, in pixels, shows. The place must be one that
// undistorted can reach.
Vec3 pixel_direction(const CameraOptics& optics, double u_px, double v_px);

// A pixel on the border of the image where the distortion has no inverse; none if all have one, and
// so all pixels inside.
std::optional<std::array<int, 2>> unseen_pixel(const CameraOptics& optics);

// Red, green and blue, linear.
using Rgb = std::array<double, 3>;

// Light from above just below the water surface, and of a lamp in the place of the camera at a
// distance of 1 m, both relative to the light in which a white surface is 1.
struct CameraLight {
  double daylight = 1, lamp = 0;
  double exposure = 1;                // factor on all colors
  std::optional<double> surface_z_m;  // of the water, in the world; absent: as if at every point
};

// The water of Akkaynak and Treibitz (2018), A Revised Underwater Image Formation Model, CVPR:
//   I = J exp(-attenuation_per_m r) + B (1 - exp(-backscatter_per_m r))
// with the color J of a surface in its light, and r along the ray. B is `veil` times the light at
// the camera. All zeros: clear water.
struct CameraWater {
  Rgb attenuation_per_m{}, backscatter_per_m{}, veil{};
};

// Downward attenuation per meter of Jerlov's water types at 600, 525 and 475 nm: N. G. Jerlov,
// Marine Optics (Elsevier 1976), Table XXVII.
struct JerlovType {
  const char* name;
  Rgb attenuation_per_m;
};
inline constexpr JerlovType kJerlovTypes[] = {
    {"I", {0.235, 0.043, 0.018}},  {"IA", {0.240, 0.048, 0.025}},  {"IB", {0.245, 0.054, 0.033}},
    {"II", {0.260, 0.076, 0.062}}, {"III", {0.295, 0.116, 0.116}}, {"1C", {0.30, 0.13, 0.17}},
    {"3C", {0.33, 0.20, 0.29}},    {"5C", {0.40, 0.31, 0.43}},     {"7C", {0.48, 0.49, 0.71}},
    {"9C", {0.60, 0.78, 1.23}},
};

struct Camera {
  CameraOptics optics;
  Pose in_sonar;  // the camera's frame in that of the sonar
  double range_max_m = 0;
  int samples = 1;  // rays along each side of a pixel, for colors
  CameraLight light = {};
  CameraWater water = {};
};

}  // namespace ensonify
