// The planes of a camera's image, one row each. All code that writes, checks or reads them loops
// over this table.
//
//   CameraPlane  kCameraPlanes
//   camera_file        its file in the sequence's folder
//   with_plane         calls a function with the values of a plane
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/image_planes.h"
#include "core/outputs.h"
#include "core/ping.h"

namespace ensonify {

struct CameraPlane {
  using Values =
      std::variant<std::vector<float> CameraView::*, std::vector<std::uint16_t> CameraView::*,
                   std::vector<std::uint8_t> CameraView::*>;
  const char* name;
  const char* unit;
  PlaneBlank blank;
  Values values;
  double file_bytes;  // of a pixel on disk, as typical images have them
  bool OutputSelection::*wanted;
  const char* file;  // what float planes of one file append to the ping's stem
  const char* meaning;
  int channels = 1;  // values of a pixel
};

inline constexpr CameraPlane kCameraPlanes[] = {
    {"depth_m", "m", PlaneBlank::nan, &CameraView::depth_m, 2.5, &OutputSelection::camera_geometry,
     "", "Distance along the axis of view, z in the camera's frame."},
    {"normal_x", "1", PlaneBlank::nan, &CameraView::normal_x, 1.2,
     &OutputSelection::camera_geometry, "",
     "Unit normal of the surface, to the right of the image."},
    {"normal_y", "1", PlaneBlank::nan, &CameraView::normal_y, 1.2,
     &OutputSelection::camera_geometry, "", "Unit normal of the surface, down the image."},
    {"normal_z", "1", PlaneBlank::nan, &CameraView::normal_z, 1.2,
     &OutputSelection::camera_geometry, "",
     "Unit normal of the surface, along the axis of view; negative: toward the camera."},
    {"instance", "", PlaneBlank::zero, &CameraView::instance, 0.05,
     &OutputSelection::camera_geometry, "", "Instance ids; 0: none."},
    {"semantic", "", PlaneBlank::zero, &CameraView::semantic, 0.05,
     &OutputSelection::camera_geometry, "", "Class ids; id k is `classes[k - 1]`, 0: none."},
    {"color", "", PlaneBlank::zero, &CameraView::color, 0.6, &OutputSelection::camera_color, "",
     "Red, green and blue, sRGB.", 3},
    {"flow_x_px", "px", PlaneBlank::nan, &CameraView::flow_x_px, 2.5, &OutputSelection::camera_flow,
     "_flow", "Motion of the pixel's point to the next ping, to the right."},
    {"flow_y_px", "px", PlaneBlank::nan, &CameraView::flow_y_px, 2.5, &OutputSelection::camera_flow,
     "_flow", "Motion of the pixel's point to the next ping, down."},
};

constexpr bool is_float_plane(const CameraPlane& plane) { return plane.values.index() == 0; }

// "camera/{ping}.exr", "camera/{ping}_instance.png".
inline std::string camera_file(const CameraPlane& plane) {
  const std::string stem = "camera/{ping}";
  return is_float_plane(plane) ? stem + plane.file + ".exr" : stem + "_" + plane.name + ".png";
}

template <class View, class Use>
decltype(auto) with_plane(View& view, const CameraPlane& plane, Use&& use) {
  return std::visit([&](auto member) -> decltype(auto) { return use(view.*member); }, plane.values);
}

}  // namespace ensonify
