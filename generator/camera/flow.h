// The motion of what a camera's pixels show.
//
//   NextShot  add_flow
#pragma once

#include <span>

#include "camera/view.h"

namespace ensonify {

// Where camera and objects are at the time of another image; objects by instance id - 1.
struct NextShot {
  Pose camera_in_world;
  std::span<const Pose> object_now, object_then;
};

// Fills flow_x_px and flow_y_px of a view with depth and instances: the place of a pixel's point in
// the other image, carried there by its object, less the pixel, rounded to kFlowQuantum_px. NaN
// where the pixel shows nothing, or the other image cannot show the point: it is behind the camera
// or where the distortion has no inverse. Places may lie outside of the other image, and something
// else may hide the point there.
void add_flow(const CameraShot& shot, const NextShot& next, CameraView& view,
              const Workers& workers);

inline constexpr double kFlowQuantum_px = 1.0 / (1 << 12);

}  // namespace ensonify
