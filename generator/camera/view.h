// What a camera sees, pixel by pixel.
//
//   camera_rays   through the centers of the pixels
//   CameraShot  camera_view
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/outputs.h"
#include "core/parallel.h"
#include "core/ping.h"
#include "trace/tracer.h"

namespace ensonify {

// [rows x columns] directions in the camera's frame, z = 1, so that a depth times a direction is
// the point that a pixel shows. The distortion must have an inverse in the image.
std::vector<Vec3> camera_rays(const CameraOptics& optics);

// The world at the moment of an image.
struct CameraShot {
  const Camera& camera;
  std::span<const Vec3> rays;  // camera_rays
  const Tracer& tracer;        // with the objects where they are
  Pose camera_in_world;
  std::span<const std::uint8_t> class_of_instance;  // by instance id, 0 included
  std::span<const std::vector<Rgb>> colors;         // ... and by Hit::part
};

// The first surface along each ray, within range_max_m of the camera.
//   depth_m   z of the point in the camera's frame, rounded to kDepthQuantum_m
//   normal_*  of the surface, on the side of the camera, rounded to kCameraNormalQuantum
//   color     with output.camera_color: camera/color.h, the mean over camera.samples^2 rays
// NaN and 0 where a ray misses; its color is that of endless water. Point targets, volumes and the
// water surface are not in it. The result does not depend on the workers.
CameraView camera_view(const CameraShot& shot, const OutputSelection& output,
                       const Workers& workers);

inline constexpr double kDepthQuantum_m = 1.0 / (1 << 20);
inline constexpr double kCameraNormalQuantum = 1.0 / (1 << 12);

}  // namespace ensonify
