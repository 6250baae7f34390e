// The keys of navigation sensors, which scenarios and sequence.json share (core/keys.h).
//
//   navigation_keys   of all sensors
#pragma once

#include <string_view>

#include "core/keys.h"
#include "core/navigation.h"

namespace ensonify {

template <class Io, class Values>
void clock_keys(Io& io, Values& clock) {
  io.number({"rate_hz", "Rate", "Samples per second", "Hz"}, clock.rate_hz, above_up_to(0, 1e4),
            kRequired);
  io.number({"time_offset_s", "Time offset",
             "Time of the first sample after the start of the path; below 0: samples before the "
             "first ping are left out",
             "s"},
            clock.time_offset_s, from_to(-1e6, 1e6));
}

template <class Io, class Values>
void mount_keys(Io& io, Values& mount) {
  constexpr NumberRange kTurn = from_to(-36000, 36000);
  io.part(
      {"mount", "Mount", "Pose of the sensor on the body; left out: that of the body"}, mount,
      [&](Io& part, auto& pose) {
        part.numbers({"position_m", "Position", "[x, y, z] on the body", "m"}, pose.position_m,
                     from_to(-1e4, 1e4));
        part.numbers({"rotation_deg", "Rotation",
                      "[roll, pitch, yaw]; without one the sensor looks down", "°"},
                     pose.rotation_deg, kTurn);
      },
      written_if(mount.has_value()));
}

template <class Io, class Values>
void gyroscope_keys(Io& io, Values& gyroscope) {
  io.number({"angle_random_walk_deg_sqrth", "Angle random walk",
             "White noise of the rate: line of slope -1/2 of the Allan deviation, at 1 h", "°/√h"},
            gyroscope.angle_random_walk_deg_sqrth, from_to(0, 1e3));
  io.number({"bias_instability_deg_h", "Bias instability",
             "Flat minimum of the Allan deviation (flicker noise)", "°/h"},
            gyroscope.bias_instability_deg_h, from_to(0, 1e5));
  io.number({"rate_random_walk_deg_h_sqrth", "Rate random walk",
             "Line of slope +1/2 of the Allan deviation, at 3 h", "°/h/√h"},
            gyroscope.rate_random_walk_deg_h_sqrth, from_to(0, 1e5));
  io.number(
      {"bias_deg_h", "Bias",
       "Standard deviation of the constant bias of each axis, sampled for each sequence", "°/h"},
      gyroscope.bias_deg_h, from_to(0, 1e6));
}

template <class Io, class Values>
void accelerometer_keys(Io& io, Values& accelerometer) {
  io.number({"velocity_random_walk_m_s_sqrth", "Velocity random walk",
             "White noise of the specific force: line of slope -1/2 of the Allan deviation, at 1 h",
             "m/s/√h"},
            accelerometer.velocity_random_walk_m_s_sqrth, from_to(0, 1e3));
  io.number({"bias_instability_ug", "Bias instability",
             "Flat minimum of the Allan deviation (flicker noise)", "µg"},
            accelerometer.bias_instability_ug, from_to(0, 1e6));
  io.number({"acceleration_random_walk_ug_sqrth", "Acceleration random walk",
             "Line of slope +1/2 of the Allan deviation, at 3 h", "µg/√h"},
            accelerometer.acceleration_random_walk_ug_sqrth, from_to(0, 1e6));
  io.number(
      {"bias_ug", "Bias",
       "Standard deviation of the constant bias of each axis, sampled for each sequence", "µg"},
      accelerometer.bias_ug, from_to(0, 1e6));
}

template <class Io, class Values>
void imu_keys(Io& io, Values& imu) {
  clock_keys(io, imu.clock);
  mount_keys(io, imu.mount);
  io.part(
      {"gyroscope", "Gyroscope", "Errors of the angular rates; left out: none"}, imu.gyroscope,
      [](Io& part, auto& values) { gyroscope_keys(part, values); },
      written_if(imu.gyroscope.has_value()));
  io.part(
      {"accelerometer", "Accelerometer", "Errors of the specific force; left out: none"},
      imu.accelerometer, [](Io& part, auto& values) { accelerometer_keys(part, values); },
      written_if(imu.accelerometer.has_value()));
}

template <class Io, class Values>
void range_keys(Io& io, Values& sensor) {
  io.number({"range_min_m", "Nearest range", "Ranges below it have no echo", "m"},
            sensor.range_min_m, from_to(0, 1e4));
  io.number({"range_max_m", "Farthest range", "Ranges beyond it have no echo", "m"},
            sensor.range_max_m, above_up_to(0, 1e5), kRequired);
}

template <class Io, class Values>
void dvl_keys(Io& io, Values& dvl) {
  clock_keys(io, dvl.clock);
  mount_keys(io, dvl.mount);
  io.number({"beam_angle_deg", "Beam angle", "Angle between each beam and the axis", "°"},
            dvl.beam_angle_deg, from_to(5, 60));
  range_keys(io, dvl);
  io.number({"velocity_noise_m_s", "Velocity noise",
             "Standard deviation of the velocity along a beam in one ping", "m/s"},
            dvl.velocity_noise_m_s, from_to(0, 100));
  io.number({"scale_error_percent", "Scale error",
             "Standard deviation of the relative error of all velocities, sampled for each "
             "sequence",
             "%"},
            dvl.scale_error_percent, from_to(0, 50));
  io.number({"range_noise_percent", "Range noise", "Standard deviation of a range", "%"},
            dvl.range_noise_percent, from_to(0, 50));
}

template <class Io, class Values>
void surface_key(Io& io, Values& sensor, std::string_view meaning) {
  io.number({"surface_z_m", "Water surface", meaning, "m"}, sensor.surface_z_m,
            from_to(-kMaxLengthM, kMaxLengthM));
}

template <class Io, class Values>
void depth_keys(Io& io, Values& depth) {
  clock_keys(io, depth.clock);
  mount_keys(io, depth.mount);
  surface_key(io, depth, "Height of depth 0 in the world");
  io.number({"noise_m", "Noise", "Standard deviation of a sample", "m"}, depth.noise_m,
            from_to(0, 1e3));
  io.number(
      {"bias_m", "Bias", "Standard deviation of the constant bias, sampled for each sequence", "m"},
      depth.bias_m, from_to(0, 1e3));
}

template <class Io, class Values>
void altimeter_keys(Io& io, Values& altimeter) {
  clock_keys(io, altimeter.clock);
  mount_keys(io, altimeter.mount);
  range_keys(io, altimeter);
  io.number({"noise_m", "Noise", "Standard deviation of a range", "m"}, altimeter.noise_m,
            from_to(0, 1e3));
}

template <class Io, class Values>
void usbl_keys(Io& io, Values& usbl) {
  clock_keys(io, usbl.clock);
  mount_keys(io, usbl.mount);
  io.numbers({"transceiver_m", "Transceiver", "[x, y, z] of the transceiver in the world", "m"},
             usbl.transceiver_m, from_to(-kMaxLengthM, kMaxLengthM), kRequired);
  io.number({"range_noise_m", "Range noise", "Standard deviation along the line of sight", "m"},
            usbl.range_noise_m, from_to(0, 1e4));
  io.number({"angle_noise_deg", "Angle noise",
             "Standard deviation of each of the two angles across the line of sight", "°"},
            usbl.angle_noise_deg, from_to(0, 90));
  io.number({"dropped", "Dropped fixes", "Probability that a fix is missing", "1"}, usbl.dropped,
            from_to(0, 0.99));
}

template <class Io, class Values>
void gps_keys(Io& io, Values& gps) {
  clock_keys(io, gps.clock);
  mount_keys(io, gps.mount);
  io.number({"latitude_deg", "Latitude", "Geodetic latitude (WGS 84) of the world's origin", "°"},
            gps.latitude_deg, from_to(-89.9, 89.9), kRequired);
  io.number({"longitude_deg", "Longitude", "Longitude of the world's origin", "°"},
            gps.longitude_deg, from_to(-180, 180), kRequired);
  io.number({"altitude_m", "Altitude", "Height of the world's origin above the ellipsoid", "m"},
            gps.altitude_m, from_to(-12000, 9000));
  surface_key(io, gps, "Height of the water surface: the antenna has a fix only above it");
  io.number({"horizontal_noise_m", "Horizontal noise",
             "Standard deviation of a fix to the east, and to the north", "m"},
            gps.horizontal_noise_m, from_to(0, 1e4));
  io.number(
      {"vertical_noise_m", "Vertical noise", "Standard deviation of the height of a fix", "m"},
      gps.vertical_noise_m, from_to(0, 1e4));
}

template <class Io, class Values>
void odometry_keys(Io& io, Values& odometry) {
  clock_keys(io, odometry.clock);
  io.number({"scale_error_percent", "Scale error",
             "Standard deviation of the relative error of horizontal distances, sampled for each "
             "sequence",
             "%"},
            odometry.scale_error_percent, from_to(0, 50));
  io.number(
      {"heading_drift_deg_h", "Heading drift",
       "Standard deviation of the constant drift of the heading, sampled for each sequence", "°/h"},
      odometry.heading_drift_deg_h, from_to(0, 1e5));
  io.number({"heading_random_walk_deg_sqrth", "Heading random walk",
             "Standard deviation of the heading error after 1 h", "°/√h"},
            odometry.heading_random_walk_deg_sqrth, from_to(0, 1e3));
}

template <class Io, class Values>
void navigation_keys(Io& io, Values& navigation) {
  const auto sensor = [&](const KeyText& text, auto& values, auto keys) {
    io.part(text, values, keys, written_if(values.has_value()));
  };
  sensor({"imu", "IMU", "Angular rates and specific force; left out: none"}, navigation.imu,
         [](Io& part, auto& values) { imu_keys(part, values); });
  sensor(
      {"dvl", "DVL", "Velocity relative to the bottom, and ranges, by four beams; left out: none"},
      navigation.dvl, [](Io& part, auto& values) { dvl_keys(part, values); });
  sensor({"depth", "Depth sensor", "Depth and pressure; left out: none"}, navigation.depth,
         [](Io& part, auto& values) { depth_keys(part, values); });
  sensor({"altimeter", "Altimeter", "Range of the nearest surface along one beam; left out: none"},
         navigation.altimeter, [](Io& part, auto& values) { altimeter_keys(part, values); });
  sensor({"usbl", "USBL", "Acoustic position fixes; left out: none"}, navigation.usbl,
         [](Io& part, auto& values) { usbl_keys(part, values); });
  sensor({"gps", "GPS", "Position fixes at the surface; left out: none"}, navigation.gps,
         [](Io& part, auto& values) { gps_keys(part, values); });
  sensor({"odometry", "Odometry", "Drifting dead reckoning of the body; left out: none"},
         navigation.odometry, [](Io& part, auto& values) { odometry_keys(part, values); });
}

}  // namespace ensonify
