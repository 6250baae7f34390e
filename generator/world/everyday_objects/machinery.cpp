// Propeller, valve and tyre; hook, shackle and chain.
#include "world/everyday_objects/everyday_objects.h"

#include <array>
#include <cmath>

#include "core/units.h"

namespace ensonify {
namespace {

// Chord and thickness of the blade at a radius, all in diameters.
struct BladeSection {
  double radius, chord, thickness;
};

// Four blades of an expanded area of 0.55, close to the outlines of the Wageningen B series. The
// first section lies within the boss.
constexpr std::array<BladeSection, 11> kBlade = {{
    {0.06, 0.16, 0.039},
    {0.10, 0.229, 0.0366},
    {0.15, 0.259, 0.0324},
    {0.20, 0.282, 0.0282},
    {0.25, 0.296, 0.0240},
    {0.30, 0.301, 0.0198},
    {0.35, 0.295, 0.0156},
    {0.40, 0.271, 0.0114},
    {0.45, 0.218, 0.0072},
    {0.485, 0.130, 0.0045},
    {0.50, 0.050, 0.0030},
}};

// A lens across the blade along x, set at the angle of the pitch.
Ring blade_ring(const BladeSection& section) {
  constexpr int kBladeCorners = 16;
  constexpr double kPitch = 0.8;  // in diameters
  const double pitch_rad = std::atan2(kPitch, 2 * kPi * section.radius);
  const Vec3 chord{0, std::cos(pitch_rad), std::sin(pitch_rad)};
  const Vec3 across{0, -std::sin(pitch_rad), std::cos(pitch_rad)};
  Ring ring;
  for (int c = 0; c < kBladeCorners; ++c) {
    const double angle = 2 * kPi * c / kBladeCorners;
    ring.push_back(Vec3{section.radius, 0, 0} + (section.chord / 2 * std::cos(angle)) * chord +
                   (section.thickness / 2 * std::sin(angle)) * across);
  }
  return ring;
}

}  // namespace

// Four blades, so that the size is the diameter; the boss is 0.18 of it, turned down at its back.
Solid propeller_solid() {
  std::vector<Ring> sections;
  for (const BladeSection& section : kBlade) sections.push_back(blade_ring(section));
  const Solid blade = loft(sections, Ends::capped);
  std::vector<Solid> parts = {
      turned({{0.09, -0.11}, {0.09, 0.09}, {0.075, 0.12}, {0.04, 0.145}}, 48)};
  for (int b = 0; b < 4; ++b) {
    parts.push_back(moved(blade, {{}, from_roll_pitch_yaw(0, 0, b * kPi / 2)}));
  }
  return joined(parts);
}

// Gate valve DN 50 PN 16, in mm: 150 from face to face (EN 558, series 14), flanges of 165 (EN
// 1092-1), shut: the bore ends at the gate. Bonnet, stem and a hand wheel of 182.
Solid valve_solid() {
  const Solid body = turned({{25, -20},
                             {25, -75},
                             {82.5, -75},
                             {82.5, -56},
                             {38, -56},
                             {38, -42},
                             {50, -28},
                             {50, 28},
                             {38, 42},
                             {38, 56},
                             {82.5, 56},
                             {82.5, 75},
                             {25, 75},
                             {25, 20}},
                            48);
  const Solid bonnet = turned({{32, 20},
                               {32, 60},
                               {58, 60},
                               {58, 78},
                               {42, 78},
                               {34, 110},
                               {16, 124},
                               {16, 150},
                               {9, 150},
                               {9, 242}},
                              32);
  constexpr double kWheelZ = 225, kWheelRadius = 82, kRim = 9, kSpoke = 6;
  std::vector<Solid> parts = {moved(body, {{}, from_roll_pitch_yaw(0, kPi / 2, 0)}), bonnet,
                              torus({0, 0, kWheelZ}, kWheelRadius, kRim, 40),
                              turned({{16, kWheelZ - 11}, {16, kWheelZ + 11}}, 24)};
  for (int s = 0; s < 3; ++s) {
    const double angle = 2 * kPi * s / 3;
    const Vec3 outwards{std::cos(angle), std::sin(angle), 0};
    const Vec3 hub{0, 0, kWheelZ};
    parts.push_back(tube({hub + 12 * outwards, hub + kWheelRadius * outwards}, kSpoke, 10));
  }
  return joined(parts);
}

// Car tyre 195/65 R15: 195 mm wide, 634 mm over all, beads of 381 mm. The carcass is a shell
// between two ellipses of one center, the inner one 0.85 of the outer, open towards the axis from
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
