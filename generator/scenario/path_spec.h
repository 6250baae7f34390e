// Where things stand and how they move, as scenarios give it.
//
//   PoseSpec        position and rotation
//   PlaceSpec  PlaceFailure  ScourSpec   somewhere on an object, left to be placed
//   TrajectorySpec  poses, a file, or one of the ways below; wave motion; when the pings go out
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/vec.h"

namespace ensonify {

// Rotation as given: roll, pitch, yaw in degrees (intrinsic z-y'-x'') or a quaternion w x y z of
// any length but zero, which pose_of normalises.
using RotationSpec = std::variant<std::array<double, 3>, Quat>;

struct PoseSpec {
  std::array<double, 3> position_m{};
  RotationSpec rotation = std::array<double, 3>{};
};

struct TimedPoseSpec {
  double time_s = 0;
  PoseSpec pose;
};
struct PathFileSpec {
  std::filesystem::path file;  // TUM (.tum, .txt) or CSV (.csv)
};

// Parallel lines to and fro, joined by half circles. All but heading and start must be given.
struct LawnmowerSpec {
  std::array<double, 3> corner_m{};  // where the first line begins
  double length_m = 0;               // of a line
  double width_m = 0;                // to port of the first line; holds the lines that fit
  double spacing_m = 0;
  double heading_deg = 0;  // of the first line, from x towards y
  double speed_m_s = 0;
  double start_time_s = 0;
};

// A level circle; its centre, radius and speed must be given.
enum class OrbitLook { inward, outward, along };
struct OrbitSpec {
  std::array<double, 3> center_m{};
  double radius_m = 0;
  double speed_m_s = 0;
  double turns = 1;      // below zero: clockwise, seen from above
  double start_deg = 0;  // bearing of the first position from the centre, from x towards y
  OrbitLook look = OrbitLook::inward;
  double start_time_s = 0;
};

// A smooth curve through at least two points; they and the speed must be given.
struct SplineSpec {
  std::vector<std::array<double, 3>> points_m;
  double speed_m_s = 0;
  std::optional<std::array<double, 3>> look_at_m;  // absent: along the way
  double start_time_s = 0;
};

// Rms values; the period of the spectrum's peak and its relative width. The period must be given.
struct WaveMotionSpec {
  double roll_deg = 0, pitch_deg = 0, yaw_deg = 0;
  double heave_m = 0;
  double period_s = 0;
  double bandwidth = 0.2;
};

// Left out: at rest at the origin. Times of poses increase strictly; a single pose needs none.
struct TrajectorySpec {
  std::variant<std::vector<TimedPoseSpec>, PathFileSpec, LawnmowerSpec, OrbitSpec, SplineSpec> path;
  std::optional<WaveMotionSpec> wave_motion;
  double ping_rate_hz = 1;   // of the sonar's
  std::optional<int> pings;  // absent: the path's own length; left out with a single pose: 1
};

// up: its z is vertical; surface: along the ground's normal; rest: it lies on a face on which it can
// stay, along the ground.
enum class PlaceAlignment { up, surface, rest };
const char* name_of(PlaceAlignment alignment);

// What becomes of a sequence in which an object finds no free place.
enum class PlaceFailure { redraw, skip_object, skip_sequence, error };
const char* name_of(PlaceFailure failure);

// A pit around an object and a mound of what was in it. With a direction (of the flow, from x to y)
// the pit is deepest upstream and the mound highest downstream; without, both are even all round.
struct ScourSpec {
  double depth_m = 0, width_m = 0;  // of the pit; the object's outline is its inner edge
  std::optional<double> mound_m;    // height of the mound; absent: half the depth
  std::optional<double> direction_deg;
};

// Somewhere in an area, standing on an object or above it; or somewhere in a box of water. `on` and
// `area_m`, or else `volume_m`, must be given.
struct PlaceSpec {
  std::string on;                                 // name of an object; empty: in mid-water
  std::array<std::array<double, 2>, 2> area_m{};  // corners [x, y] in the world
  std::optional<std::array<std::array<double, 3>, 2>> volume_m = {};  // corners [x, y, z] likewise
  double height_m = 0;                            // above where it would stand
  double clearance_m = 0.2;                       // between outlines, seen from above
  double sink_m = 0;                              // straight down into the ground
  double buried_fraction = 0;                     // of its height; comes to sink_m
  bool any_yaw = true;                            // turned by a drawn angle; else as `rotation` says
  PlaceAlignment align = PlaceAlignment::up;
  bool touching = false;  // moved until its outline touches the nearest other one
  bool heap = false;      // what lies on the same ground is ground, too
  RotationSpec rotation = std::array<double, 3>{};  // before it is turned and aligned
  PlaceFailure on_failure = PlaceFailure::redraw;
  std::optional<ScourSpec> scour = {};  // on terrain alone
};

}  // namespace ensonify
