// Navigation sensors of the body that carries the sonar, with their errors in the terms of data
// sheets. Sensors look along -z of their frame: a mount without rotation looks down.
//
//   Imu  Dvl  DepthSensor  Altimeter  Usbl  Gps  Odometry  Navigation   navigation_keys.h: the keys
//   NavigationInfo   of a sequence
#pragma once

#include <array>
#include <optional>

#include "core/vec.h"

namespace ensonify {

struct SensorMount {
  std::array<double, 3> position_m{};    // on the body
  std::array<double, 3> rotation_deg{};  // roll, pitch, yaw
};

// Samples are at start of the path + time_offset_s + k / rate_hz.
struct SensorClock {
  double rate_hz = 0;
  double time_offset_s = 0;
};

// Standard deviations; all 0: no errors. IEEE Std 952 has the terms. A bias instability is the flat
// minimum of the Allan deviation.
struct Gyroscope {
  double angle_random_walk_deg_sqrth = 0;
  double bias_instability_deg_h = 0;
  double rate_random_walk_deg_h_sqrth = 0;
  double bias_deg_h = 0;  // from one sequence to another
};
struct Accelerometer {
  double velocity_random_walk_m_s_sqrth = 0;
  double bias_instability_ug = 0;
  double acceleration_random_walk_ug_sqrth = 0;
  double bias_ug = 0;
};
struct Imu {
  SensorClock clock;
  std::optional<SensorMount> mount = {};
  std::optional<Gyroscope> gyroscope = {};  // absent: without errors
  std::optional<Accelerometer> accelerometer = {};
};

// Four beams at the same angle from the axis (Janus), 45 degrees from forward.
struct Dvl {
  SensorClock clock;
  std::optional<SensorMount> mount = {};
  double beam_angle_deg = 30;
  double range_min_m = 0.1, range_max_m = 0;
  double velocity_noise_m_s = 0;   // of a beam
  double scale_error_percent = 0;  // of the velocity, from one sequence to another
  double range_noise_percent = 0;
};

struct DepthSensor {
  SensorClock clock;
  std::optional<SensorMount> mount = {};
  double surface_z_m = 0;
  double noise_m = 0;
  double bias_m = 0;  // from one sequence to another
};

struct Altimeter {
  SensorClock clock;
  std::optional<SensorMount> mount = {};
  double range_min_m = 0.1, range_max_m = 0;
  double noise_m = 0;
};

struct Usbl {
  SensorClock clock;
  std::optional<SensorMount> mount = {};  // of the transponder
  std::array<double, 3> transceiver_m{};  // in the world
  double range_noise_m = 0;
  double angle_noise_deg = 0;  // of each of two angles
  double dropped = 0;          // probability that a fix is missing
};

struct Gps {
  SensorClock clock;
  std::optional<SensorMount> mount = {};                       // of the antenna
  double latitude_deg = 0, longitude_deg = 0, altitude_m = 0;  // of the world's origin
  double surface_z_m = 0;                                      // fixes only above it
  double horizontal_noise_m = 0, vertical_noise_m = 0;
};

// Dead reckoning of the body. Depth, roll and pitch have no drift.
struct Odometry {
  SensorClock clock;
  double scale_error_percent = 0;  // of the distance, from one sequence to another
  double heading_drift_deg_h = 0;  // from one sequence to another
  double heading_random_walk_deg_sqrth = 0;
};

struct Navigation {
  std::optional<Imu> imu = {};
  std::optional<Dvl> dvl = {};
  std::optional<DepthSensor> depth = {};
  std::optional<Altimeter> altimeter = {};
  std::optional<Usbl> usbl = {};
  std::optional<Gps> gps = {};
  std::optional<Odometry> odometry = {};
};

// The sensors of a sequence, and where the sonar is on the body.
struct NavigationInfo {
  Navigation sensors;
  Pose sonar_in_body;
};

}  // namespace ensonify
