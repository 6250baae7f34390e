// Positions and trajectories as a scenario states them.
//
//   PoseSpec        position and rotation
//   PlaceSpec  PlaceFailure  ScourSpec   a random place on an object or in the water
//   TrajectorySpec  poses, a file or one of the paths below; wave motion; ping times
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/vec.h"

namespace ensonify {

// Rotation as given: roll, pitch, yaw in degrees (intrinsic z-y'-x''), or a quaternion w x y z of
// any length above zero, which pose_of normalizes.
using RotationSpec = std::variant<std::array<double, 3>, Quat>;

struct PoseSpec {
  std::array<double, 3> position_m{};
  RotationSpec rotation = std::array<double, 3>{};
};

Pose pose_of(const PoseSpec& spec);

struct TimedPoseSpec {
  double time_s = 0;
  PoseSpec pose;
};
struct PathFileSpec {
  std::filesystem::path file;  // TUM (.tum, .txt) or CSV (.csv)
};

// Parallel lines in alternating directions, joined by half circles. All keys but heading and start
// are required.
struct LawnmowerSpec {
  std::array<double, 3> corner_m{};  // where the first line starts
  double length_m = 0;               // of each line
  double width_m = 0;                // to port of the first line; filled with as many lines as fit
  double spacing_m = 0;
  double heading_deg = 0;  // of the first line, from x toward y
  double speed_m_s = 0;
  double start_time_s = 0;
};

// A horizontal circle; its center, radius and speed are required.
enum class OrbitLook { inward, outward, along };
struct OrbitSpec {
  std::array<double, 3> center_m{};
  double radius_m = 0;
  double speed_m_s = 0;
  double turns = 1;      // negative: clockwise, seen from above
  double start_deg = 0;  // bearing of the first position from the center, from x toward y
  OrbitLook look = OrbitLook::inward;
  double start_time_s = 0;
};

// A smooth curve through at least two points; the points and the speed are required.
struct SplineSpec {
  std::vector<std::array<double, 3>> points_m;
  double speed_m_s = 0;
  std::optional<std::array<double, 3>> look_at_m;  // absent: along the path
  double start_time_s = 0;
};

// Rms values, the period of the spectrum's peak and the relative width of the spectrum. The period
// is required.
struct WaveMotionSpec {
  double roll_deg = 0, pitch_deg = 0, yaw_deg = 0;
  double heave_m = 0;
  double period_s = 0;
  double bandwidth = 0.2;
};

// If left out, the body is at rest at the origin. Times of poses increase strictly; a single pose
// needs no time.
struct TrajectorySpec {
  std::variant<std::vector<TimedPoseSpec>, PathFileSpec, LawnmowerSpec, OrbitSpec, SplineSpec> path;
  std::optional<WaveMotionSpec> wave_motion;
  double ping_rate_hz = 1;   // of the sonar
  std::optional<int> pings;  // absent: as many as the path lasts; 1 with a single pose
  bool from_first_ping = false;  // of an object: moved in time, to start with the first ping
};

// up: the z axis is vertical; surface: it is normal to the ground; rest: the object lies on a
// stable face on the ground.
enum class PlaceAlignment { up, surface, rest };
const char* name_of(PlaceAlignment alignment);

// The reaction if an object of a sequence finds no free place.
enum class PlaceFailure { redraw, skip_object, skip_sequence, error };
const char* name_of(PlaceFailure failure);

// A pit around an object and a mound of the same volume. With a direction (of the flow, from x to
// y) the pit is deepest upstream and the mound highest downstream; without one, both are the same
// all around.
struct ScourSpec {
  double depth_m = 0, width_m = 0;  // of the pit, whose inner edge is the outline of the object
  std::optional<double> mound_m;    // height of the mound; absent: half of the depth
  std::optional<double> direction_deg;
};

// A random place in an area, standing on an object or above it, or in a box of water. Either `on`
// and `area_m` or `volume_m` are required.
struct PlaceSpec {
  std::string on;                                 // name of an object; empty: in the water
  std::array<std::array<double, 2>, 2> area_m{};  // corners [x, y] in the world
  std::optional<std::array<std::array<double, 3>, 2>> volume_m = {};  // corners [x, y, z]
  double height_m = 0;                            // above the place where it would stand
  double clearance_m = 0.2;                       // between outlines, seen from above
  double sink_m = 0;                              // down into the ground
  double buried_fraction = 0;                     // of the object's height, in addition to sink_m
  bool any_yaw = true;                            // turned by a random angle; else as `rotation`
  PlaceAlignment align = PlaceAlignment::up;
  bool touching = false;  // moved until its outline touches that of the nearest object
  bool heap = false;      // other objects on the same ground are ground, too
  RotationSpec rotation = std::array<double, 3>{};  // before it is turned and aligned
  PlaceFailure on_failure = PlaceFailure::redraw;
  std::optional<ScourSpec> scour = {};  // on terrain only
};

}  // namespace ensonify
