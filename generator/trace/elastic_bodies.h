// The echoes of elastic spheres and cylinders that are objects.
//
//   elastic_scatterers
#pragma once

#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "trace/line_pieces.h"

namespace ensonify {

// Coherent scatterers of the objects that ring, without variance: of a sphere one at its center for
// each tap, of a cylinder one for each tap and piece of its axis, whose taps are per meter. A place is
// heard if the straight ray to it meets its object first. The near field of a body is left out:
// spreading and direction are those of the center or axis.
std::vector<Scatterer> elastic_scatterers(const PlacedWorld& placed, const Sonar& sonar,
                                          const Water& water, const Workers& workers);

}  // namespace ensonify
