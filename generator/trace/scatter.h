// Hits to scatterers: the physics of one echo, put on record.
//
//   SurfaceScattering  material_at   what a sequence fixes
//   surface_scatterers     one scatterer for each ray that found something
//   surface_scatterer_list the same, sorted
//   point_target_scatterers  school_scatterers  HiddenTarget
//   has_smooth_surfaces  kirchhoff_scatterers   the coherent echo of smooth surfaces
//   PointScatterers  hidden_echoes   hits behind others
#pragma once

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "core/sonar.h"
#include "trace/refracted.h"
#include "trace/tracer.h"
#include "world/world.h"

namespace ensonify {

struct SurfaceScattering {
  Sonar sonar;
  Water water;
  std::vector<Material> material;  // by instance id; [0] is unused
  // By instance id, then Hit::part - 1; empty where no object has parts.
  std::vector<std::vector<Material>> part_material = {};
};

inline const Material& material_at(const SurfaceScattering& scattering, const Hit& hit) {
  return hit.part == 0 ? scattering.material[hit.instance]
                       : scattering.part_material[hit.instance][hit.part - 1];
}

SurfaceScattering make_surface_scattering(const Sonar& sonar, const Water& water,
                                          const World& world);

// One scatterer a usable hit (Choi et al. 2021, Eq 1-14): moments by the material's law, gain
// r^-2 10^(-absorption 2r/20) B_el(elevation) B_tx(azimuth), delay 2r/c, keyed by its ray. `hits`
// in the order of ray_index. A ray is left out, alone, when it missed, when its range is not a
// finite number in [range_min, range_max] above zero, or when its incidence is not one in [0, 1].
std::vector<Scatterer> surface_scatterers(const Fan& fan, std::span<const Hit> hits,
                                          const SurfaceScattering& scattering);

// The same as a list, as sorted_by_beam_and_delay would make it; beams are shared out. `paths`: of
// refracted rays, else empty. Then dA = A/dOmega of the ray's tube, and the gain is
// 10^(-absorption 2s/20) B_el B_tx / two_way_spreading_m2 with the path's length s.
ScattererList surface_scatterer_list(const Fan& fan, std::span<const Hit> hits,
                                     const SurfaceScattering& scattering, const Workers& workers,
                                     std::span<const RayPath> paths = {});

// A point target or a fish behind a surface, as it would be heard were that not there.
struct HiddenTarget {
  Scatterer scatterer;
  std::uint32_t occluder = 0;  // the instance that alone hides it; 0: several do
};

// Point targets inside the fan and its ranges with no surface before them; amplitude 10^(TS/20).
// Those with one are added to `hidden`, where it is given. Where the water bends rays, along the
// fastest one; what lies in a shadow zone is left out.
std::vector<Scatterer> point_target_scatterers(const World& world, const Tracer& tracer,
                                               const Pose& sonar_in_world, const Sonar& sonar,
                                               const Water& water,
                                               std::vector<HiddenTarget>* hidden = nullptr);

// The fish of all schools likewise.
std::vector<Scatterer> school_scatterers(const World& world, const Tracer& tracer,
                                         const Pose& sonar_in_world, const Sonar& sonar,
                                         const Water& water, const Workers& workers,
                                         std::vector<HiddenTarget>* hidden = nullptr);

// Whether any material has `coherent: kirchhoff`.
bool has_smooth_surfaces(const SurfaceScattering& scattering);

// The coherent scatterers of all surfaces whose material says kirchhoff, without variance; the
// random part of the same surfaces is in surface_scatterers. Each cell of the fan whose ray, or a
// neighbour's, meets such a surface gets rays through its corners and the middles of its sides. It
// is taken on its own where the range is linear in both angles to 0.2 rad of two-way phase (the
// bend enters the amplitude to first order) and changes by no more than c/24b along either side.
// Otherwise it is cut in two across the side that asks for it, and so are the halves, down to a
// quarter of a wavelength. A part that a body's edge runs through is cut down to an eighth, to a
// thirty-second where the edge runs along its sides; then its middle decides. A body that all rays
// of the fan miss is not found.
// In a fixed order, whatever the workers. `hits` in the order of ray_index.
std::vector<Scatterer> kirchhoff_scatterers(const Fan& fan, std::span<const Hit> hits,
                                            const Tracer& tracer, const Pose& sonar_in_world,
                                            const SurfaceScattering& scattering,
                                            const Workers& workers);

// Point targets and fish.
struct PointScatterers {
  std::vector<Scatterer> heard;
  std::vector<HiddenTarget> hidden;
};

// Every hit behind a ray's first gives the scatterer that surface_scatterers would make of it,
// without coherent echoes of mirrors. The first behind it is hidden by the ray's own instance
// alone. `instances`: how many the world has. Whether volumes weaken them is the caller's
// (attenuate).
HiddenEchoes hidden_echoes(const Fan& fan, std::span<const Hit> hits, const FanHitsBehind& behind,
                           const PointScatterers& points, const SurfaceScattering& scattering,
                           std::size_t instances, const Workers& workers);

}  // namespace ensonify
