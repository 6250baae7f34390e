// The members of a camera in sequence.json. Private to dataset/.
//
//   camera_members   in the order of the file, for each class of json_members.h
#pragma once

namespace ensonify {

// Of a Camera, and of the OutputSelection of its files.
template <class Io, class Value, class Output>
void camera_members(Io& io, Value& camera, Output& output) {
  auto& optics = camera.optics;
  io("width_px", optics.width_px);
  io("height_px", optics.height_px);
  io("focal_x_px", optics.focal_x_px);
  io("focal_y_px", optics.focal_y_px);
  io("center_x_px", optics.center_x_px);
  io("center_y_px", optics.center_y_px);
  io.group("distortion", [&](Io& d) {
    d("k1", optics.k1);
    d("k2", optics.k2);
    d("p1", optics.p1);
    d("p2", optics.p2);
    d("k3", optics.k3);
  });
  io.said("pixel", "(0, 0) is the center of the first pixel, column and row");
  io.said("frame", "x to the right of the image, y down, z along the axis of view");
  io.group("in_sonar", [&](Io& pose) {
    pose("position_m", camera.in_sonar.position_m);
    pose("quaternion_wxyz", camera.in_sonar.rotation);
  });
  io("range_max_m", camera.range_max_m);
  io("samples", camera.samples);
  io.group("light", [&](Io& light) {
    light("daylight", camera.light.daylight);
    light("lamp", camera.light.lamp);
    light("exposure", camera.light.exposure);
    light("surface_z_m", camera.light.surface_z_m);
  });
  io.group("water", [&](Io& water) {
    water("attenuation_per_m", camera.water.attenuation_per_m);
    water("backscatter_per_m", camera.water.backscatter_per_m);
    water("veil", camera.water.veil);
  });
  io("geometry", output.camera_geometry);
  io("color", output.camera_color);
  io("flow", output.camera_flow);
}

}  // namespace ensonify
