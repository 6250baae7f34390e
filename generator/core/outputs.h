// What is made of a ping and written of a sequence.
//
//   OutputSelection  no_outputs
//   OutputFlag  kOutputFlags   what may be asked of a ping, by name
//   flag_of                    the row of a member
#pragma once

#include "core/units.h"

namespace ensonify {

struct OutputSelection {
  bool timeseries = true;  // as NPY
  bool polar = true;
  bool cartesian = true;
  bool png = true;
  bool scatterers = false;
  bool points = false;
  bool shadow = true;            // beside polar and Cartesian images
  bool amodal = true;            // in the annotations of all images
  bool multipath = false;        // ghost masks beside polar and Cartesian images
  bool surfaces = false;         // planes of the surfaces in each pixel; needs `polar`
  bool clean_single = false;     // the expected level in single precision; needs `polar`
  bool front = false;            // the first surfaces in each direction
  bool camera_geometry = false;  // depth, normals and labels of the camera's pixels; needs a camera
  bool camera_color = false;     // ... and their colors
  bool camera_flow = false;      // ... and their motion to the next ping
  bool artifact = false;         // masks of what the electronics add; needs Sonar::front_end
  bool motion = false;           // of each pixel's point to another ping; needs `polar`
  int motion_pings = 1;          // how many pings later that is; negative: earlier
  bool covisibility = false;     // between the pings of a sequence
  bool world = false;            // the scene of a sequence as meshes
  bool elevation = false;        // echoes over elevation
  double elevation_step_rad = radians(0.5);
  bool elevation_volumes = false;  // ... of volumes too
  bool polygons = false;
  bool timeseries_exr = false;
  bool layers = false;
  bool cartesian_exr = false;  // float planes of Cartesian images too; needs `cartesian`
  bool channels = false;       // the signal of each array element
  bool packed = false;         // arrays of all pings instead of files per ping
  bool statistics = false;     // over all pings of a sequence, which then show one scene
  int statistics_lags = 0;     // samples and beams between pixels that are correlated; 0: none
  double statistics_within_db = 20;  // ... and histogram: of the largest expected level
  bool pings = true;                 // false: pings have no files
  bool labels = true;                // false: of a recording, which has levels only

  bool any_camera() const { return camera_geometry || camera_color || camera_flow; }
  bool any_timeseries() const { return timeseries || timeseries_exr; }
};

inline OutputSelection no_outputs() {
  OutputSelection none;
  none.timeseries = none.polar = none.cartesian = none.png = none.shadow = none.amodal = false;
  return none;
}

// A member of OutputSelection that brings arrays of a ping, and another member without which it
// brings none; null: it needs no other. With a title, its key in scenarios is this row: a switch
// that is off unless given. Without, scenario/output.cpp lists the key.
struct OutputFlag {
  const char* name;
  bool OutputSelection::*member;
  bool OutputSelection::*needs = nullptr;
  const char* title = nullptr;
  const char* meaning = nullptr;  // of the schema and docs/scenario_keys.md
};

inline constexpr OutputFlag kOutputFlags[] = {
    {"timeseries", &OutputSelection::timeseries},
    {"timeseries_exr", &OutputSelection::timeseries_exr},
    {"polar", &OutputSelection::polar},
    {"cartesian", &OutputSelection::cartesian},
    {"cartesian_exr", &OutputSelection::cartesian_exr, &OutputSelection::cartesian},
    {"png", &OutputSelection::png},
    {"shadow", &OutputSelection::shadow},
    {"amodal", &OutputSelection::amodal},
    {"multipath", &OutputSelection::multipath},
    {"surfaces", &OutputSelection::surfaces, &OutputSelection::polar, "Surface planes",
     "EXR files next to polar images with elevation, range and normal of the surfaces of each "
     "pixel's instance, and their number; the number of surfaces of all instances, and the second "
     "instance and its share; needs polar"},
    {"clean_single", &OutputSelection::clean_single, &OutputSelection::polar,
     "Expected level in single precision",
     "EXR files next to polar images with clean_db in single precision, since half precision has "
     "steps of 1/16 dB from 64 dB on and of 1/8 dB from 128 dB on; needs polar"},
    {"front", &OutputSelection::front},
    {"camera_geometry", &OutputSelection::camera_geometry},
    {"camera_color", &OutputSelection::camera_color},
    {"camera_flow", &OutputSelection::camera_flow},
    {"motion", &OutputSelection::motion, &OutputSelection::polar},
    {"elevation", &OutputSelection::elevation},
    {"layers", &OutputSelection::layers},
    {"channels", &OutputSelection::channels},
};

// Null for a member without a row.
constexpr const OutputFlag* flag_of(bool OutputSelection::*member) {
  for (const OutputFlag& flag : kOutputFlags) {
    if (flag.member == member) return &flag;
  }
  return nullptr;
}

}  // namespace ensonify
