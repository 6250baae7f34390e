// The keys of `camera` and of `output.camera`, and the check that the distortion has an inverse.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/units.h"
#include "scenario/rig.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

constexpr int kMostPixels = 8192;  // along a side
constexpr NumberRange kFieldOfView = from_to(1, 170);
constexpr NumberRange kFocal = from_to(1, 1e6);
constexpr NumberRange kCenter = from_to(-1e5, 1e5);
constexpr NumberRange kDistortion = from_to(-100, 100);

void focal_fields(Fields& f, CameraSpec& camera) {
  constexpr std::string_view kKeys[] = {"fov_deg", "focal_px"};
  const auto which = f.only_key(kKeys, camera.fov_deg ? 0 : 1, "either fov_deg or focal_px");
  if (which == 0u) {
    f.number({kKeys[0], "Field of view",
              "Angle that the width of the image spans without distortion; in place of focal_px"},
             camera.fov_deg, kFieldOfView);
  }
  if (which == 1u) {
    f.number(
        {kKeys[1], "Focal length",
         "Focal length in pixels, or [x, y] of pixels that are not square; in place of fov_deg",
         "px"},
        camera.focal_px, kFocal, {}, 2);
  }
}

void distortion_fields(Fields& f, CameraSpec& camera) {
  const CameraSpec none;
  const auto coefficient = [&](std::string_view key, std::string_view title, const char* meaning,
                               double& value) {
    f.number({key, title, meaning, "1"}, value, kDistortion, written_if(value != 0));
  };
  const bool is_given = optics_of(camera).is_distorted();
  if (!f.begin({"distortion", "Distortion",
                "Coefficients of the distortion in the order and convention of OpenCV, for points "
                "of the image plane at distance 1; left out: none"},
               written_if(is_given, {.has_default = false}))) {
    return;
  }
  coefficient("k1", "k1", "Radial, of r²; below 0: barrel, above 0: pincushion", camera.k1);
  coefficient("k2", "k2", "Radial, of r⁴", camera.k2);
  coefficient("p1", "p1", "Tangential, of an image turned about x", camera.p1);
  coefficient("p2", "p2", "Tangential, of an image turned about y", camera.p2);
  coefficient("k3", "k3", "Radial, of r⁶", camera.k3);
  f.end();
}

void water_fields(Fields& f, CameraWaterSpec& water) {
  constexpr std::string_view kKeys[] = {"jerlov", "attenuation_per_m"};
  constexpr NumberRange kAttenuation = from_to(0, 100);
  const auto which = f.only_key(kKeys, water.jerlov ? 0 : 1, "either jerlov or attenuation_per_m");
  if (which == 0u) {
    std::vector<std::string_view> types;
    for (const JerlovType& type : kJerlovTypes) types.emplace_back(type.name);
    std::size_t type = water.jerlov.value_or(0);
    const KeyText text = {kKeys[0], "Jerlov type",
                          "Water type of Jerlov, from the clearest ocean, I, to the most turbid "
                          "coast, 9C; in place of attenuation_per_m"};
    if (f.word(text, types, type, kRequired)) water.jerlov = type;
  }
  if (which == 1u) {
    f.numbers({kKeys[1], "Attenuation",
               "Attenuation of red, green and blue along a ray, in place of jerlov", "1/m"},
              water.attenuation_per_m, kAttenuation);
  }
  f.numbers({"backscatter_per_m", "Backscatter",
             "Rate at which the veil of red, green and blue builds up along a ray; left out: as "
             "the attenuation",
             "1/m"},
            water.backscatter_per_m, kAttenuation);
  f.numbers(
      {"veil", "Veil",
       "Color of endless water relative to the light at the camera, red, green and blue; left "
       "out: 0.2 in the clearest color, in the others in inverse proportion to the "
       "attenuation",
       "1"},
      water.veil, from_to(0, 10));
}

void light_fields(Fields& f, CameraLight& light) {
  constexpr NumberRange kLight = from_to(0, 1e6);
  f.number({"daylight", "Daylight",
            "Light from above just below the water surface, relative to that in which a white "
            "surface is white",
            "1"},
           light.daylight, kLight);
  f.number(
      {"lamp", "Lamp",
       "Light of a lamp in the place of the camera at a distance of 1 m, relative to the same; "
       "0: none",
       "1"},
      light.lamp, kLight);
  f.number({"exposure", "Exposure", "Factor on all colors before they become 8 bits", "1"},
           light.exposure, kLight);
}

void check_distortion(Fields& f, const CameraSpec& camera) {
  const auto pixel = unseen_pixel(optics_of(camera));
  if (!pixel) return;
  const Value distortion = child_or_empty(f.reader()->map(), "distortion");
  add_fault(
      f.reader()->faults(), distortion.place, distortion.path,
      fmt::format("the distortion folds the image, so that nothing is seen at pixel ({}, {}); "
                  "expected coefficients with an inverse in all of the image, or a longer "
                  "focal length or smaller image",
                  (*pixel)[0], (*pixel)[1]));
}

}  // namespace

CameraWater water_of(const CameraWaterSpec& spec) {
  CameraWater water;
  water.attenuation_per_m = spec.jerlov ? kJerlovTypes[*spec.jerlov].attenuation_per_m
                                        : spec.attenuation_per_m.value_or(Rgb{});
  water.backscatter_per_m = spec.backscatter_per_m.value_or(water.attenuation_per_m);
  const Rgb& per_m = water.attenuation_per_m;
  const double clearest = std::min({per_m[0], per_m[1], per_m[2]});
  for (std::size_t c = 0; c < 3; ++c) {
    water.veil[c] = per_m[c] > 0 ? kVeil * clearest / per_m[c] : kVeil;
  }
  water.veil = spec.veil.value_or(water.veil);
  return water;
}

CameraOptics optics_of(const CameraSpec& spec) {
  CameraOptics optics{.width_px = spec.width_px,
                      .height_px = spec.height_px,
                      .k1 = spec.k1,
                      .k2 = spec.k2,
                      .p1 = spec.p1,
                      .p2 = spec.p2,
                      .k3 = spec.k3};
  if (spec.fov_deg) {
    optics.focal_x_px = optics.focal_y_px =
        spec.width_px / 2.0 / std::tan(radians(*spec.fov_deg) / 2);
  } else if (!spec.focal_px.values.empty()) {
    optics.focal_x_px = spec.focal_px.values.front();
    optics.focal_y_px = spec.focal_px.values.back();
  }
  optics.center_x_px = spec.center_px ? (*spec.center_px)[0] : (spec.width_px - 1) / 2.0;
  optics.center_y_px = spec.center_px ? (*spec.center_px)[1] : (spec.height_px - 1) / 2.0;
  return optics;
}

void fields(Fields& f, CameraSpec& camera) {
  const ReadWatch watch(f);
  f.map({"mount", "Mount",
         "Pose of the camera on the body that the trajectory moves: x along the axis of view, y to "
         "the left of the image, z up"},
        camera.mount);
  f.integer({"width_px", "Width", "Columns of the image"}, camera.width_px, 1, kMostPixels);
  f.integer({"height_px", "Height", "Rows of the image"}, camera.height_px, 1, kMostPixels);
  focal_fields(f, camera);
  f.numbers({"center_px", "Principal point",
             "[column, row] of the axis of view, [0, 0] at the center of the first pixel; left "
             "out: the middle of the image",
             "px"},
            camera.center_px, kCenter);
  distortion_fields(f, camera);
  f.number({"range_max_m", "Farthest range", "Surfaces farther away are not seen"},
           camera.range_max_m, kLength);
  f.integer({"samples", "Rays of a pixel",
             "Rays along each side of a pixel, over which its color is averaged"},
            camera.samples, 1, 8, written_if(camera.samples != 1));
  if (f.begin({"light", "Light", "Light of the colors"})) {
    light_fields(f, camera.light);
    f.end();
  }
  if (f.begin({"water", "Water of the colors",
               "What the water does to colors, after Akkaynak and Treibitz 2018; left out: clear"},
              written_if(camera.water.has_value(), {.has_default = false}))) {
    if (!camera.water) camera.water.emplace();
    water_fields(f, *camera.water);
    f.end();
  }
  f.number({"surface_z_m", "Water surface",
            "Height of the water surface in the world, which the camera stays below; left out: "
            "that of multipath.surface or water.profile, otherwise none"},
           camera.surface_z_m, kPosition);
  if (watch.is_well()) check_distortion(f, camera);
}

void camera_output_fields(Fields& f, const Scenario& scenario, OutputSelection& selection) {
  const bool is_there = has_camera(scenario);
  if (!f.writing()) selection.camera_geometry = selection.camera_color = is_there;
  bool on = selection.any_camera();
  const bool is_entered = f.begin_switch(
      {"camera", "Images of the camera",
       "Which files each image of the camera has; needs the section camera; a map of options "
       "switches them on and off one by one; left out: as the options state where there is a "
       "camera"},
      on, written_if(is_there, {.has_default = false}));
  if (!f.writing() && !on) selection.camera_geometry = selection.camera_color = false;
  if (is_entered) {
    f.toggle({"geometry", "Depth, normals and labels",
              "EXR files with depth and normals, and PNG files with instance and class ids"},
             selection.camera_geometry);
    f.toggle({"color", "Colors", "PNG files with colors"}, selection.camera_color);
    f.toggle({"flow", "Optical flow",
              "EXR files with the motion of each pixel's point to the next ping, in pixels"},
             selection.camera_flow);
    f.end();
  }
  if (f.writing() || is_there || !on) return;
  f.fault("camera", "the scenario has no camera; expected the section camera as well");
}

}  // namespace ensonify
