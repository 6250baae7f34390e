#include "world/everyday_objects/everyday_objects.h"

#include <algorithm>
#include <utility>

#include "core/units.h"

namespace ensonify {
namespace {

Solid solid_of(ModelKind kind) {
  constexpr std::pair<ModelKind, Solid (*)()> kSolids[] = {
      {ModelKind::bottle, bottle_solid},   {ModelKind::can, can_solid},
      {ModelKind::tyre, tyre_solid},       {ModelKind::chain, chain_solid},
      {ModelKind::hook, hook_solid},       {ModelKind::propeller, propeller_solid},
      {ModelKind::valve, valve_solid},     {ModelKind::carton, carton_solid},
      {ModelKind::shackle, shackle_solid}, {ModelKind::wall, wall_solid},
      {ModelKind::pipe, pipe_solid},       {ModelKind::crab_pot, crab_pot_solid},
      {ModelKind::ladder, ladder_solid},   {ModelKind::net, net_solid}};
  return std::find_if(std::begin(kSolids), std::end(kSolids),
                      [&](const auto& row) { return row.first == kind; })
      ->second();
}

}  // namespace

Mesh model_mesh(ModelKind kind, double size_m) {
  const Solid solid = solid_of(kind);
  Bounds bounds;
  for (const Vec3& p : solid.vertices) bounds.add(p);
  const Vec3 size = bounds.size(), middle = bounds.middle();
  const double scale = size_m / std::max({size.x, size.y, size.z});
  const Vec3 foot{middle.x, middle.y, bounds.low.z};
  Mesh mesh;
  for (const Vec3& p : solid.vertices) mesh.vertices.push_back(to_floats(scale * (p - foot)));
  mesh.triangles = solid.triangles;
  return mesh;
}

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

// A piece of wall one brick thick: 1 m long, 0.6 m high, 0.24 m through.
Solid wall_solid() { return box({1, 0.24, 0.6}); }

}  // namespace ensonify
