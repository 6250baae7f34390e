// The sharp edges of bodies, at which sound is diffracted; fixed for a sequence. Their echoes are
// in edge_echoes.cpp.
//
//   Edge  BodyEdges
//   diffracts  diffracting_edges
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface.h"
#include "core/units.h"
#include "trace/line_pieces.h"
#include "world/world.h"

namespace ensonify {

// An edge turns its faces by this or more.
inline constexpr double kSharpEdge_rad = radians(40);

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

// Whether the edges of a body of this material have echoes of their own.
inline bool diffracts(const Material& material) {
  return material.coherent == CoherentModel::kirchhoff && material.edges;
}

// The edges of all objects and parts with `coherent: {model: kirchhoff, edges: true}`: those of
// boxes, both rims of cylinders, and edges of meshes whose faces turn by 40 degrees or more or that
// have one face. Meshes of terrain have none, nor have mesh edges between more than two faces or
// between two parts. Vertices at the same place count as one.
std::vector<BodyEdges> diffracting_edges(const World& world, double wavelength_m);

}  // namespace ensonify
