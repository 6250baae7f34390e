// The surfaces that fall into each pixel of a polar image.
//
//   SurfaceInput  NormalsAt  add_surfaces   their elevations, ranges, normals and number
#pragma once

#include <cstdint>
#include <functional>
#include <span>

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

}  // namespace ensonify
