#include <cmath>

#include "core/units.h"
#include "world/models/models.h"

namespace ensonify {
namespace {

// Studless anchor chain link, in diameters of its bar: 6 long, 3.35 wide (ISO 1704).
Solid link() {
  constexpr double kBend = 1.175, kHalfStraight = 2.5 - kBend;
  std::vector<TubePoint> curve;
  for (const double end : {1.0, -1.0}) {
    const double from = end > 0 ? -kPi / 2 : kPi / 2;
    for (const Vec3& p : arc({end * kHalfStraight, 0, 0}, kBend, from, from + kPi, 8)) {
      curve.push_back({p, 0.5});
    }
  }
  return tube(curve, {0, 0, 1}, 8, Ends::looped);
}

}  // namespace

// Eleven links, each tilted 45 deg on the bottom, the next one to the other side, in a gentle bend.
// Neighbours are 4 diameters apart, so that they touch.
Solid chain_solid() {
  constexpr int kLinks = 11;
  constexpr double kBendRad = radians(25);
  const Solid one = link();
  std::vector<Solid> links;
  Vec3 joint;
  for (int k = 0; k < kLinks; ++k) {
    const double heading = kBendRad * std::cos(2 * kPi * k / (kLinks - 1));
    const double roll = (k % 2 == 0 ? 1 : -1) * kPi / 4;
    const Vec3 half_pitch = 2.0 * Vec3{std::cos(heading), std::sin(heading), 0};
    links.push_back(moved(one, {joint + half_pitch, from_roll_pitch_yaw(roll, 0, heading)}));
    joint = joint + 2.0 * half_pitch;
  }
  return joined(links);
}

}  // namespace ensonify
