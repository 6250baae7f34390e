// Unevenness of a surface, or of a volume: a random field in the coordinates of its object.
//
//   SurfaceField   make_texture  make_growth
//   ObjectFields   make_fields   of an object's own material and of its parts
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/ping.h"
#include "core/random.h"
#include "core/surface.h"
#include "core/vec.h"

namespace ensonify {

struct ObjectSpec;
struct Scenario;

// A Gaussian field on a lattice that repeats after 64 cells along each of its axes, interpolated to
// unit variance everywhere, then mapped by `values`, a table over [-kFieldEnd, kFieldEnd].
struct SurfaceField {
  double per_m = 1;            // lattice cells per meter
  std::vector<float> lattice;  // 64^3
  std::vector<float> values;

  // The value at a position in the object's frame.
  float at(Vec3 local_m) const;

  std::size_t bytes() const { return (lattice.size() + values.size()) * sizeof(float); }
};

// The factor on the reflectivity of a surface or the density of a volume, with mean 1:
// gamma-distributed, or 10^(level/10) of a normal level. The correlation of the Gaussian field
// falls to 1/e at correlation_m.
std::shared_ptr<const SurfaceField> make_texture(const SurfaceTexture& texture, std::uint64_t key);

// A field that is 1 on the share `cover` of the surface, which has another material, and 0
// elsewhere.
std::shared_ptr<const SurfaceField> make_growth(double cover, double correlation_m,
                                                std::uint64_t key);

// The fields of a material that affect its hits; index k of ObjectFields belongs to Hit::part k.
struct MaterialFields {
  std::shared_ptr<const SurfaceField> texture = nullptr, growth = nullptr;
  std::shared_ptr<const SurfaceField> growth_texture = nullptr;  // of the material that has grown
  std::uint16_t growth_part = 0;                                 // Hit::part where it grows
};
using ObjectFields = std::vector<MaterialFields>;

// The fields of an object's material and of those of its parts, keyed by the names of the object
// and of the materials, so that other objects do not change them. Empty if all materials are even.
// Materials of growth are added to `parts` and to the instance, whose parts must be known.
ObjectFields make_fields(const Scenario& scenario, const ObjectSpec& object, SequenceDraw draw,
                         const std::map<std::string, Material>& materials, PartMaterials& parts,
                         Instance& instance);

}  // namespace ensonify
