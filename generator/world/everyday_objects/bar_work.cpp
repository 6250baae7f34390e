// Pipe, crab pot, ladder and net, all in mm.
#include <cmath>

#include "core/units.h"
#include "world/everyday_objects/everyday_objects.h"

namespace ensonify {
namespace {

// A straight bar between two points that lie apart along one axis.
Solid bar(Vec3 from, Vec3 to, double radius, int corners) {
  const bool upright = from.z != to.z;
  return tube(std::vector<TubePoint>{{from, radius}, {to, radius}},
              upright ? Vec3{1, 0, 0} : Vec3{0, 0, 1}, corners);
}

// Size of the crab pot between the axes of its frame, and the wires between two of its bars.
constexpr Vec3 kPot{610, 610, 460};
constexpr int kPotWires = 9, kPotWiresUp = 6;

// The bars of the frame along an axis, and the wires along it in the four walls that hold some.
void add_bars_along(int axis, std::vector<Solid>& parts) {
  const double size[] = {kPot.x, kPot.y, kPot.z};
  const int wires[] = {kPotWires, kPotWires, kPotWiresUp};
  const int across[] = {(axis + 1) % 3, (axis + 2) % 3};
  const auto add = [&](double u, double v, double radius, int corners) {
    double from[3], to[3];
    from[axis] = -size[axis] / 2;
    to[axis] = size[axis] / 2;
    from[across[0]] = to[across[0]] = u * size[across[0]];
    from[across[1]] = to[across[1]] = v * size[across[1]];
    parts.push_back(bar({from[0], from[1], from[2]}, {to[0], to[1], to[2]}, radius, corners));
  };
  for (const double side : {-0.5, 0.5}) {
    for (const double other : {-0.5, 0.5}) add(side, other, 5, 8);
    for (int i = 1; i <= wires[across[1]]; ++i) {
      add(side, static_cast<double>(i) / (wires[across[1]] + 1) - 0.5, 2, 6);
    }
    for (int i = 1; i <= wires[across[0]]; ++i) {
      add(static_cast<double>(i) / (wires[across[0]] + 1) - 0.5, side, 2, 6);
    }
  }
}

}  // namespace

// Steel pipe DN 100, 2 m long, with a flange PN 16 at either end (EN 1092-1): 114.3 outside, bore
// 100, flanges 220 x 20. The bore is open.
Solid pipe_solid() {
  const Solid upright = turned({{50, -1000},
                                {110, -1000},
                                {110, -980},
                                {57.15, -980},
                                {57.15, 980},
                                {110, 980},
                                {110, 1000},
                                {50, 1000}},
                               48, Ends::looped);
  return moved(upright, {{}, from_roll_pitch_yaw(0, kPi / 2, 0)});
}

// Pot of 24 x 24 x 18 inches: a frame of 10 mm bars, walls of coated 4 mm wire about 60 mm apart,
// and a funnel of sheet in each of two walls, open at both ends.
Solid crab_pot_solid() {
  std::vector<Solid> parts;
  for (int axis = 0; axis < 3; ++axis) add_bars_along(axis, parts);
  const Solid funnel = turned({{100, 0}, {55, 150}, {59, 150}, {104, 0}}, 16, Ends::looped);
  for (const double side : {-1.0, 1.0}) {
    parts.push_back(
        moved(funnel, {{0, side * kPot.y / 2, 0}, from_roll_pitch_yaw(side * kPi / 2, 0, 0)}));
  }
  return joined(parts);
}

// Section of a ladder, 2 m: stiles of 70 x 25 at 400 from axis to axis, seven rungs of 30, 280
// apart (EN 131 has 250 to 300).
Solid ladder_solid() {
  std::vector<Solid> parts;
  for (const double y : {-200.0, 200.0}) {
    parts.push_back(moved(box({2000, 25, 70}), {{0, y, 0}, {}}));
  }
  for (int rung = -3; rung <= 3; ++rung) {
    const double x = 280.0 * rung;
    parts.push_back(bar({x, -200, 0}, {x, 200, 0}, 15, 16));
  }
  return joined(parts);
}

// A piece of trawl netting, 2 m x 1.4 m with square meshes of 100 and double twine of 8, in two
// folds 300 high.
Solid net_solid() {
  constexpr double kMesh = 100, kTwine = 4, kHeight = 300, kFold = 1000;
  constexpr int kAlong = 10, kHalfAcross = 7;
  const auto knot = [&](int i, double y) {
    const double x = i * kMesh;
    return Vec3{x, y, kHeight / 2 * (1 - std::cos(2 * kPi * x / kFold))};
  };
  std::vector<Solid> parts;
  for (int j = -kHalfAcross; j <= kHalfAcross; ++j) {
    std::vector<TubePoint> twine;
    for (int i = -kAlong; i <= kAlong; ++i) twine.push_back({knot(i, j * kMesh), kTwine});
    parts.push_back(tube(twine, {0, 1, 0}, 4));
  }
  for (int i = -kAlong; i <= kAlong; ++i) {
    parts.push_back(bar(knot(i, -kHalfAcross * kMesh), knot(i, kHalfAcross * kMesh), kTwine, 4));
  }
  return joined(parts);
}

}  // namespace ensonify
