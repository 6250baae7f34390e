// Hook, shackle and chain.
#include <cmath>

#include "core/units.h"
#include "world/everyday_objects/everyday_objects.h"

namespace ensonify {
namespace {

// Turned about z, then laid along y.
Solid across(const std::vector<ProfilePoint>& profile) {
  return moved(turned(profile, 32), {{}, from_roll_pitch_yaw(-kPi / 2, 0, 0)});
}

}  // namespace

// Eye hook, as parts of its length: the load hangs in the middle of the bowl, in line with the eye;
// the bar is thickest under the load and tapers to the point.
Solid hook_solid() {
  const Vec3 bowl{0.27, 0, 0};
  constexpr double kBowlRadius = 0.2, kShank = 0.04, kThickest = 0.055, kPoint = 0.018;
  const double back_rad = radians(60), bottom_rad = kPi, point_rad = radians(320);
  const Vec3 back = bowl + kBowlRadius * Vec3{std::cos(back_rad), std::sin(back_rad), 0};
  const Vec3 along_back{-std::sin(back_rad), std::cos(back_rad), 0};
  const std::vector<Vec3> shank =
      bezier({{{0.77, 0, 0}, {0.6, 0, 0}, back - 0.15 * along_back, back}}, 10);
  std::vector<TubePoint> bar;
  for (std::size_t i = 0; i + 1 < shank.size(); ++i) bar.push_back({shank[i], kShank});
  constexpr int kSteps = 30;
  const std::vector<Vec3> bend = arc(bowl, kBowlRadius, back_rad, point_rad, kSteps);
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = back_rad + (point_rad - back_rad) * i / kSteps;
    const bool past = angle > bottom_rad;
    const double end_rad = past ? point_rad : back_rad, end_radius = past ? kPoint : kShank;
    const double away = (angle - bottom_rad) / (end_rad - bottom_rad);
    bar.push_back(
        {bend[static_cast<std::size_t>(i)], kThickest + (end_radius - kThickest) * away * away});
  }
  return joined({torus({0.86, 0, 0}, 0.1, kShank, 32), tube(bar, {0, 0, 1}, 16)});
}

// Anchor shackle, in diameters of its bow: pin 1.13, jaw 1.69, bow 2.69 wide inside, 3.75 from the
// pin to the bow's inside, eyes 2.38 (a forged screw pin shackle of one inch, in inches). It rests
// on its eyes and on the bow, which is thinner: that tilts it.
Solid shackle_solid() {
  constexpr double kBow = 0.5, kEye = 1.19, kPin = 0.565, kLeg = 0.845 + kBow;
  constexpr double kBend = 1.345 + kBow, kCrown = 3.75 + kBow;
  const Vec3 centre{kCrown - kBend, 0, 0};
  const double end_rad = radians(110);
  const Vec3 end = centre + kBend * Vec3{std::cos(end_rad), std::sin(end_rad), 0};
  const Vec3 along{-std::sin(end_rad), std::cos(end_rad), 0};
  const std::vector<Vec3> leg =
      bezier({{end, end + 0.93 * along, {0.6, kLeg, 0}, {0, kLeg, 0}}}, 8);
  std::vector<Vec3> curve;
  for (auto p = leg.rbegin(); p != leg.rend(); ++p) curve.push_back({p->x, -p->y, 0});
  const std::vector<Vec3> bend = arc(centre, kBend, -end_rad, end_rad, 24);
  curve.insert(curve.end(), bend.begin() + 1, bend.end() - 1);
  curve.insert(curve.end(), leg.begin(), leg.end());
  std::vector<Solid> parts = {tube(curve, kBow, 16)};
  for (const double y : {-kLeg, kLeg}) {
    parts.push_back(across({{kEye - 0.15, y - kBow},
                            {kEye, y - kBow + 0.15},
                            {kEye, y + kBow - 0.15},
                            {kEye - 0.15, y + kBow}}));
  }
  const double outside = kLeg + kBow;
  parts.push_back(across({{kPin, -outside - 0.3},
                          {kPin, outside + 0.02},
                          {0.85, outside + 0.02},
                          {0.85, outside + 0.6}}));
  const double tilt_rad = std::asin((kEye - kBow) / kCrown);
  return moved(joined(parts), {{}, from_roll_pitch_yaw(0, tilt_rad, 0)});
}

namespace {

// Studless anchor chain link, in diameters of its bar: 6 long, 3.35 wide (ISO 1704).
Solid link() {
  constexpr double kBend = 1.175, kHalfStraight = 2.5 - kBend;
  std::vector<Vec3> curve;
  for (const double end : {1.0, -1.0}) {
    const double from = end > 0 ? -kPi / 2 : kPi / 2;
    const std::vector<Vec3> bend = arc({end * kHalfStraight, 0, 0}, kBend, from, from + kPi, 8);
    curve.insert(curve.end(), bend.begin(), bend.end());
  }
  return tube(curve, 0.5, 8, Ends::looped);
}

}  // namespace

// Eleven links, each tilted 45 deg on the bottom, the next one to the other side, in a gentle bend.
// Neighbors are 4 diameters apart, so that they touch.
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
