// Bottle, can and carton, as closed bodies: no sound gets in.
#include <utility>

#include "core/units.h"
#include "world/models/models.h"

namespace ensonify {
namespace {

constexpr int kRoundCorners = 96;

Solid lying(Solid standing) {
  return moved(std::move(standing), {{}, from_roll_pitch_yaw(0, kPi / 2, 0)});
}

}  // namespace

// Longneck glass bottle of 330 ml: 229 mm high, 61 mm wide, crown finish of 27 mm.
Solid bottle_solid() {
  return lying(turned({{26, 0},
                       {30.5, 5},
                       {30.5, 104},
                       {26.5, 124},
                       {19, 143},
                       {15, 161},
                       {13.5, 212},
                       {13.5, 229}},
                      kRoundCorners));
}

// Drinks can of 330 ml: 115 mm high, 66 mm wide, drawn in to a rim of 54 mm and a foot of 48 mm.
Solid can_solid() {
  return lying(turned({{24, 0}, {33, 10}, {33, 103}, {27, 115}}, kRoundCorners));
}

// Carton of one litre: 195 mm x 90 mm x 60 mm hold 1.05 l.
Solid carton_solid() { return box({195, 90, 60}); }

}  // namespace ensonify
