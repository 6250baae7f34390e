// Diffraction at the sharp edges of bodies.
//
//   Edge  BodyEdges  diffracting_edges   fixed for a sequence
//   edge_scatterers                      the echoes of one ping
#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "trace/line_pieces.h"
#include "world/world.h"

namespace ensonify {

struct SurfaceScattering;

// A straight piece of an edge, in the frame of its object.
struct Edge {
  Line line;
  // Into both faces, at right angles to the edge, unit length; equal at the rim of an open sheet.
  Vec3 first, second;
  std::uint16_t part = 0;  // as Hit::own_part

  bool is_rim() const { return first == second; }
};

struct BodyEdges {
  std::size_t object = 0;  // of World::objects
  std::vector<Edge> edges;
};

// The edges of all objects and parts with `coherent: {model: kirchhoff, edges: true}`: those of
// boxes, both rims of cylinders, and edges of meshes whose faces turn by 40 degrees or more or that
// have one face. Meshes of terrain have none, nor have mesh edges between more than two faces or
// between two parts. Vertices at the same place count as one.
std::vector<BodyEdges> diffracting_edges(const World& world, double wavelength_m);

// Coherent scatterers of those pieces of scattering.edges that the sonar sees, without variance:
//   a = |R| f dl/(2 pi) sinc(2 dl cos(beta)/lambda),   f = fringe_diffraction,
// with the angle beta between edge and ray, and R = coherent_reflection of the face that is seen
// more nearly at normal incidence. They are what kirchhoff_scatterers leaves out. Pieces are those
// of pieces_of. Edges whose exterior angle on the side of the sonar is below pi give none.
std::vector<Scatterer> edge_scatterers(const PlacedWorld& view, const SurfaceScattering& scattering,
                                       const Workers& workers);

}  // namespace ensonify
