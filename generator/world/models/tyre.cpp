#include <cmath>

#include "core/units.h"
#include "world/models/models.h"

namespace ensonify {

// Car tyre 195/65 R15: 195 mm wide, 634 mm over all, beads of 381 mm. The carcass is a shell
// between two ellipses of one centre, the inner one 0.85 of the outer, open towards the axis from
// 140 deg on either side of the tread's middle.
Solid tyre_solid() {
  constexpr double kOuterRadius = 317, kBeadRadius = 190.5, kHalfWidth = 97.5, kInner = 0.85;
  constexpr int kSteps = 16;
  const double open_rad = radians(140);
  const double half_height = (kOuterRadius - kBeadRadius) / (1 - std::cos(open_rad));
  const double centre = kOuterRadius - half_height;
  std::vector<ProfilePoint> loop;
  for (const double shell : {1.0, kInner}) {
    for (int i = 0; i <= kSteps; ++i) {
      const double direction = shell == 1 ? 1 : -1;  // there outside, back inside
      const double angle = direction * open_rad * (2.0 * i / kSteps - 1);
      loop.push_back(
          {centre + shell * half_height * std::cos(angle), shell * kHalfWidth * std::sin(angle)});
    }
  }
  return turned(loop, 64, Ends::looped);
}

}  // namespace ensonify
