// What the files of navigation sensors hold, and what follows from the sensors for all readers.
//
//   NavigationTable  kNavigationTables  has_table   the files of a sequence, and their columns
//   mount_of                    pose of a sensor on the body
//   dvl_beams  inverse_normal   directions of the beams, and the velocity from those with a lock
//   kGravityMS2  kAtmospherePa
#pragma once

#include "core/navigation.h"

namespace ensonify {

inline constexpr double kGravityMS2 = 9.80665;   // along -z of the world
inline constexpr double kAtmospherePa = 101325;  // at the water surface

enum class NavigationTable { imu, imu_truth, dvl, depth, altimeter, usbl, gps, odometry };

struct NavigationFile {
  const char* name;  // in the folder of the sequence
  const char* header;
};

// By NavigationTable.
inline constexpr NavigationFile kNavigationTables[] = {
    {"navigation/imu.csv",
     "time_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2\n"},
    {"navigation/imu_truth.csv",
     "time_s,x,y,z,qw,qx,qy,qz,vx_m_s,vy_m_s,vz_m_s,gyro_bias_x_rad_s,gyro_bias_y_rad_s,"
     "gyro_bias_z_rad_s,accel_bias_x_m_s2,accel_bias_y_m_s2,accel_bias_z_m_s2\n"},
    {"navigation/dvl.csv",
     "time_s,vx_m_s,vy_m_s,vz_m_s,altitude_m,range_0_m,range_1_m,range_2_m,range_3_m,"
     "beam_0_m_s,beam_1_m_s,beam_2_m_s,beam_3_m_s\n"},
    {"navigation/depth.csv", "time_s,depth_m,pressure_pa\n"},
    {"navigation/altimeter.csv", "time_s,range_m\n"},
    {"navigation/usbl.csv", "time_s,x,y,z\n"},
    {"navigation/gps.csv", "time_s,latitude_deg,longitude_deg,altitude_m\n"},
    {"navigation/odometry.csv",
     "time_s,x,y,z,qw,qx,qy,qz,vx_m_s,vy_m_s,vz_m_s,wx_rad_s,wy_rad_s,wz_rad_s\n"},
};

bool has_table(const Navigation& navigation, NavigationTable table);

Pose mount_of(const std::optional<SensorMount>& mount);

// Unit vectors in the frame of the DVL (x forward, y port, z up), beam k at 45 + 90 k degrees from
// x toward y.
std::array<Vec3, 4> dvl_beams(const Dvl& dvl);

// The inverse of sum_k b_k b_k^T over beams with a lock, which are three or more: times the
// variance of a beam's velocity it is the covariance of the velocity by least squares. Rows.
using DvlNormal = std::array<Vec3, 3>;
DvlNormal inverse_normal(const std::array<Vec3, 4>& beams, const std::array<bool, 4>& locked);

}  // namespace ensonify
