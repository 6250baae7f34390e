// Hits behind others to hidden echoes.
//
//   PointScatterers  hidden_echoes
#pragma once

#include <span>
#include <vector>

#include "core/hidden.h"
#include "core/parallel.h"
#include "trace/scatter.h"

namespace ensonify {

// Point targets and fish.
struct PointScatterers {
  std::vector<Scatterer> heard;
  std::vector<HiddenTarget> hidden;
};

// Of every hit behind a ray's first the scatterer that surface_scatterers would make of it; without
// coherent echoes of mirrors. The first behind it is hidden by the ray's own instance alone.
// `instances`: how many the world has. Whether volumes weaken them is the caller's (attenuate).
HiddenEchoes hidden_echoes(const Fan& fan, std::span<const Hit> hits, const FanHitsBehind& behind,
                           const PointScatterers& points, const SurfaceScattering& scattering,
                           std::size_t instances, const Workers& workers);

}  // namespace ensonify
