// Propeller, valve and tyre.
#include <array>
#include <cmath>

#include "core/units.h"
#include "world/everyday_objects/everyday_objects.h"

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

}  // namespace ensonify
