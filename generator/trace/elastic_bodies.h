// The echoes of elastic spheres and cylinders that are objects.
//
//   elastic_scatterers
#pragma once

#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "trace/line_pieces.h"
#include "trace/scatter.h"

namespace ensonify {

// Coherent scatterers of the objects that ring, without variance: of a sphere one at its center for
// each tap, of a cylinder one for each tap and piece dl of its axis, times dl sinc(2 dl cos(beta)/
// lambda) with the angle beta between axis and ray. A place is heard if the straight ray to it meets
// its object first; otherwise it is added to `hidden`, if given. The near field of a body is left
// out: spreading, direction and range are those of the center or axis.
std::vector<Scatterer> elastic_scatterers(const PlacedWorld& placed, const Sonar& sonar,
                                          const Water& water, const Workers& workers,
                                          std::vector<HiddenTarget>* hidden = nullptr);

}  // namespace ensonify
