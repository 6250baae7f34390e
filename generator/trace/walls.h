// The effect of walls on the echo of a path. Private to trace/.
//
//   WallEvent  wall_event  WallEvents   the walls that a path passes through or reflects off
//   add_with_walls                      the scatterers of an echo
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "acoustics/plate.h"
#include "core/scatterers.h"
#include "trace/tracer.h"

namespace ensonify {

// Most walls that one path passes through, out and back together.
inline constexpr int kMostPasses = 8;

struct WallEvent {
  const WallResponse* wall = nullptr;
  float sine = 0;  // of the angle of incidence
  bool reflected = false;
  std::uint32_t instance = 0;
};

inline WallEvent wall_event(const WallResponse* wall, const Hit& hit, bool reflected) {
  const float cosine = hit.cos_incidence;
  return {wall, std::sqrt(std::max(1 - cosine * cosine, 0.0f)), reflected, hit.instance};
}

struct WallEvents {
  static constexpr int kMost = kMostPasses + 2 * (kMostBounces + 1);

  int count = 0, passed = 0;
  std::array<WallEvent, kMost> event;

  // Returns false if the path already has the maximum number of walls.
  bool add(const WallEvent& wall) {
    if (count == kMost || (!wall.reflected && passed == kMostPasses)) return false;
    passed += !wall.reflected;
    event[count++] = wall;
    return true;
  }
  bool add(const WallEvents& others) {
    for (int i = 0; i < others.count; ++i) {
      if (!add(others.event[i])) return false;
    }
    return true;
  }
};

// Appends the echo with the effect of its walls: one scatterer for each tap of the product of their
// responses. All scatterers keep the echo's key, and therefore its random draw. If the path passes
// through walls, the scatterers get the path id of such a path, and `via` also lists the walls as
// far as there is room.
void add_with_walls(Scatterer echo, const WallEvents& walls, const Sonar& sonar, const Water& water,
                    std::vector<Scatterer>& scatterers);

}  // namespace ensonify
