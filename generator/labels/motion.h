// Where the surface point of each pixel of a polar image lies in another ping.
//
//   MotionsOf  MotionInput  add_motion
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "core/motion.h"
#include "core/parallel.h"
#include "core/ping.h"
#include "labels/polar.h"

namespace ensonify {

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
