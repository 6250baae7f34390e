// The surfaces that collapse into each pixel of a polar image.
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

// Fills in one normal for each of the scatterers, given by their places in the list: unit length,
// sonar frame, towards the sonar; NaN where a scatterer is on no surface. Called by several threads
// at once.
using NormalsAt =
    std::function<void(std::span<const std::uint32_t> scatterers, std::span<Vec3> normals)>;

struct SurfaceInput {
  const PolarInput& heard;
  double sound_speed_m_s = 0;     // of the range axis
  double elevation_step_rad = 0;  // between the rays of a column
  NormalsAt normals_at;
};

// Adds the planes of surfaces to polar_image's image. They describe the direct scatterers of the
// pixel's instance within c/2b of its sample in its own sector; volumes have no surface. Range is
// c/2 times the delay, elevation that of arrival.
//   surface_*            the scatterer of largest expected energy E|a|^2 gain^2, the nearest of
//   equal lowest_*, highest_*  the scatterers of least and of largest elevation surface_count one
//   more than the gaps between neighbours in elevation of more than
//                        kSurfaceGap steps: a ray through a gap meets nothing of the instance there
// NaN and 0 where a pixel has no instance or its instance no scatterer. Rounded to
// kSurfaceAngleQuantum_rad, kSurfaceRangeQuantum_m and kSurfaceNormalQuantum, since digits beyond
// them take most of the file and mean nothing.
void add_surfaces(const SurfaceInput& input, const Workers& workers, LabelledImage& image);

inline constexpr double kSurfaceGap = 1.5;
inline constexpr double kSurfaceAngleQuantum_rad = 1.0 / (1 << 17);
inline constexpr double kSurfaceRangeQuantum_m = 1.0 / (1 << 13);
inline constexpr double kSurfaceNormalQuantum = 1.0 / (1 << 12);

}  // namespace ensonify
