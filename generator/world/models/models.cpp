#include "world/models/models.h"

#include <algorithm>
#include <limits>

namespace ensonify {
namespace {

Solid solid_of(ModelKind kind) {
  switch (kind) {
    case ModelKind::bottle:
      return bottle_solid();
    case ModelKind::can:
      return can_solid();
    case ModelKind::tyre:
      return tyre_solid();
    case ModelKind::chain:
      return chain_solid();
    case ModelKind::hook:
      return hook_solid();
    case ModelKind::propeller:
      return propeller_solid();
    case ModelKind::valve:
      return valve_solid();
    case ModelKind::carton:
      return carton_solid();
    case ModelKind::shackle:
      return shackle_solid();
    case ModelKind::wall:
      return wall_solid();
  }
  return {};
}

}  // namespace

Mesh model_mesh(ModelKind kind, double size_m) {
  const Solid solid = solid_of(kind);
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Vec3 low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
  for (const Vec3& p : solid.vertices) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vec3 extent = high - low;
  const double scale = size_m / std::max({extent.x, extent.y, extent.z});
  const Vec3 foot{(low.x + high.x) / 2, (low.y + high.y) / 2, low.z};
  Mesh mesh;
  for (const Vec3& p : solid.vertices) {
    const Vec3 q = scale * (p - foot);
    mesh.vertices.push_back(
        {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)});
  }
  mesh.triangles = solid.triangles;
  return mesh;
}

}  // namespace ensonify
