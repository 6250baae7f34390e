// Faces with more than three corners, divided into triangles.
//
//   DividedFace  divide_face
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace ensonify {

struct DividedFace {
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices into the corners
  // False if the face crosses itself, so that triangles overlap or are turned over. False as well
  // if it is so far from flat that it crosses itself as seen along its mean normal.
  bool simple = true;
};

// Divides a face of three or more corners into triangles with its winding, whichever corner comes
// first. The triangles of a simple face cover it once and nothing else, if it is flat; corners on
// an edge, edges that run there and back (bridges to holes) and parts that touch are no crossings.
// Every corner belongs to a triangle, as long as one with area can have it, so that neighbors meet
// without gaps. Errors of position up to 1e-5 of the size of the face do not count as crossings.
DividedFace divide_face(const std::vector<std::array<float, 3>>& corners);

}  // namespace ensonify
