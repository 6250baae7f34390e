// Samples of the navigation sensors other than the IMU: rows of their tables
// (core/navigation_tables.h).
//
//   FindRange                 range of the nearest surface along a ray
//   simulate_dvl  simulate_altimeter
//   simulate_depth  simulate_usbl  simulate_gps  simulate_odometry
//   Geodetic  geodetic_of     latitude, longitude and height of a place in the world
#pragma once

#include <functional>

#include "core/navigation.h"
#include "navigation/course.h"

namespace ensonify {

// From a place in the world along a unit vector, at a time, up to a range; NaN without a surface.
using FindRange =
    std::function<double(double time_s, Vec3 from_m, Vec3 direction, double range_max_m)>;

// Beam k with a surface within the limits of range has the velocity v . b_k, positive toward the
// bottom, and a range; others have NaN. The velocity, in the frame of the DVL, is that by least
// squares of three beams or more, and the altitude is the mean of range cos(beam angle) over the
// beams; otherwise NaN. The bottom is taken to be at rest.
void simulate_dvl(const Dvl& dvl, const Course& course, const FindRange& find_range,
                  const EmitRow& row);

// Along -z of its frame; NaN without a surface within the limits of range.
void simulate_altimeter(const Altimeter& altimeter, const Course& course,
                        const FindRange& find_range, const EmitRow& row);

// Absolute pressure: that of the atmosphere and of the water above.
void simulate_depth(const DepthSensor& depth, double density_kg_m3, const Course& course,
                    const EmitRow& row);

void simulate_usbl(const Usbl& usbl, const Course& course, const EmitRow& row);

// Samples below the surface have no row.
void simulate_gps(const Gps& gps, const Course& course, const EmitRow& row);

// Starts at the body's pose at the first sample. Horizontal steps are longer by the scale error and
// turned by the heading error, a drift and a random walk; height, roll and pitch are true.
void simulate_odometry(const Odometry& odometry, const Course& course, const EmitRow& row);

struct Geodetic {
  double latitude_deg = 0, longitude_deg = 0, altitude_m = 0;  // WGS 84
};
// Of a place whose x, y, z are east, north and up at the origin of `gps`. Heights within 1 um up to
// 100 km from the origin.
Geodetic geodetic_of(const Gps& gps, Vec3 place_m);

}  // namespace ensonify
