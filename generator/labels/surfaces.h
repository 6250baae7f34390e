// The surfaces that fall into each pixel of a polar image, and where its strongest point lies in
// another ping.
//
//   SurfaceInput  NormalsAt  add_surfaces   elevations, ranges, normals and number of the surfaces
//   MotionInput  MotionsOf  add_motion      the place of the point in both pings
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "core/image_planes.h"
#include "core/parallel.h"
#include "core/ping.h"
#include "core/vec.h"
#include "labels/polar.h"

namespace ensonify {

// Writes one normal for each of the scatterers, given by their indices in the list: unit length,
// sonar frame, toward the sonar; NaN if a scatterer is not on a surface. Called by several threads
// at once.
using NormalsAt =
    std::function<void(std::span<const std::uint32_t> scatterers, std::span<Vec3> normals)>;

struct SurfaceInput {
  const PolarInput& heard;
  double sound_speed_m_s = 0;     // of the range axis
  double elevation_step_rad = 0;  // between the rays of a column
  NormalsAt normals_at;
};

// Adds the planes of surfaces to polar_image's image. The planes describe the direct scatterers of
// the pixel's instance in its beam cell within c/2b of its sample; volumes have no surface. Range
// is c/2 times the delay, elevation that of arrival.
//   surface_*            the scatterer of largest expected energy E|a|^2 gain^2; of equal ones the
//                        nearest
//   lowest_*, highest_*  the scatterers of least and of largest elevation
//   surface_count        1 + the number of gaps of more than kSurfaceGap steps between neighbors in
//                        elevation: a ray through such a gap meets nothing of the instance there
//   layover_count        the sum of this over all instances with a direct scatterer in the pixel
// NaN and 0 if a pixel has no instance, or its instance no scatterer. Values are rounded to
// kSurfaceAngleQuantum_rad, kSurfaceRangeQuantum_m and kSurfaceNormalQuantum, because further
// digits would fill most of the file without meaning.
void add_surfaces(const SurfaceInput& input, const Workers& workers, LabelledImage& image);

inline constexpr double kSurfaceGap = 1.5;
inline constexpr double kSurfaceAngleQuantum_rad = 1.0 / (1 << 17);
inline constexpr double kSurfaceRangeQuantum_m = 1.0 / (1 << 13);
inline constexpr double kSurfaceNormalQuantum = 1.0 / (1 << 12);

// Writes one motion for each of the scatterers, given by their indices in the list. Called by
// several threads at once.
using MotionsOf = std::function<void(std::span<const std::uint32_t> scatterers,
                                     std::span<PointMotion> motions)>;

struct MotionInput {
  const PolarInput& heard;
  MotionsOf motions_of;
};

// Adds the planes of motion to polar_image's image. The point of a pixel is the direct scatterer of
// its instance, in its beam cell within c/2b of its sample, that has the largest expected energy
// (of equal ones the nearest), as for surface_elevation_rad.
//   point_sample, point_beam       the point's place in this ping
//   motion_samples, motion_beams   its place in the other ping less that
//   motion_state                   PointState there
//   motion_occluder                the instance that hides it there; 0: none
// NaN and 0 if a pixel has no instance, or its instance no point on a surface. Places and
// displacements are rounded to kMotionQuantum.
void add_motion(const MotionInput& input, const Workers& workers, LabelledImage& image);

inline constexpr double kMotionQuantum = 1.0 / (1 << 10);

}  // namespace ensonify
