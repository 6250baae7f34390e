// From hits to scatterers: the physics of one echo.
//
//   surface_scatterers     one scatterer for each usable hit
//   surface_scatterer_list the same, sorted
//   point_target_scatterers  school_scatterers  HiddenTarget
//   has_smooth_surfaces  kirchhoff_scatterers   the coherent echo of smooth surfaces
//   edge_scatterers        diffraction at the edges of bodies
//   elastic_scatterers     the echoes of elastic spheres and cylinders that are objects
//   PointScatterers  hidden_echoes   hits behind others
#pragma once

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "core/sonar.h"
#include "trace/line_pieces.h"
#include "trace/refracted.h"
#include "trace/surface_scattering.h"
#include "trace/tracer.h"
#include "world/world.h"

namespace ensonify {

// One scatterer for each usable hit (Choi et al. 2021, Eq 1-14), with the moments of the material's
// law, the gain r^-2 10^(-absorption 2r/20) B_el(elevation) B_tx(azimuth), the delay 2r/c and the
// key of its ray. `hits` in the order of ray_index. A ray gives no scatterer if it missed, if its
// range is not finite, above zero and in [range_min, range_max], or if its cosine of incidence is
// not in [0, 1].
std::vector<Scatterer> surface_scatterers(const Fan& fan, std::span<const Hit> hits,
                                          const SurfaceScattering& scattering);

// The same as a list in the order of sorted_by_beam_and_delay; the workers share the beams. `paths`
// are those of refracted rays, and empty for straight rays. With paths, the tube's A/dOmega
// replaces r^2 in dA, and the gain is 10^(-absorption 2s/20) B_el B_tx / two_way_spreading_m2 with
// the path's length s.
ScattererList surface_scatterer_list(const Fan& fan, std::span<const Hit> hits,
                                     const SurfaceScattering& scattering, const Workers& workers,
                                     std::span<const RayPath> paths = {});

// A point target or fish behind a surface, with the echo that it would have without that surface.
struct HiddenTarget {
  Scatterer scatterer;
  std::uint32_t occluder = 0;  // the only instance that hides it; 0: several do
  bool has_rays = false;       // an object, whose rays count how much of it is hidden
};

// Point targets inside the fan and its ranges that no surface hides; amplitude 10^(TS/20), or one
// echo for each of its taps, at the range of its center. Hidden ones are added to `hidden`, if
// given. If rays are refracted, the echo takes the fastest path; a target in a shadow zone has
// none.
std::vector<Scatterer> point_target_scatterers(const World& world, const Tracer& tracer,
                                               const Pose& sonar_in_world, const Sonar& sonar,
                                               const Water& water,
                                               std::vector<HiddenTarget>* hidden = nullptr);

// The same for the fish of all schools.
std::vector<Scatterer> school_scatterers(const World& world, const Tracer& tracer,
                                         const Pose& sonar_in_world, const Sonar& sonar,
                                         const Water& water, const Workers& workers,
                                         std::vector<HiddenTarget>* hidden = nullptr);

// Whether any material has `coherent: kirchhoff`.
bool has_smooth_surfaces(const SurfaceScattering& scattering);

// The coherent scatterers of all surfaces with a kirchhoff material, without variance; the random
// part of these surfaces is in surface_scatterers. Each cell of the fan whose ray, or a neighbor's,
// meets such a surface gets rays through its corners and the middles of its sides. It is one
// scatterer if the range is linear in both angles to 0.2 rad of two-way phase (the amplitude
// includes the bend to first order) and changes by no more than c/24b along either side. Otherwise
// it is cut in two across the side that needs it. The halves are cut in the same way, down to a
// quarter of a wavelength. A part that contains an edge of a body is cut down to an eighth of a
// wavelength, or to a thirty-second if the edge runs along its sides; then its middle decides. A
// body that all rays of the fan miss is not found. The order does not depend on the workers. `hits`
// in the order of ray_index. `all_hits`: those of the whole fan, if `fan` is that of a group.
std::vector<Scatterer> kirchhoff_scatterers(const Fan& fan, std::span<const Hit> hits,
                                            const Tracer& tracer, const Pose& sonar_in_world,
                                            const SurfaceScattering& scattering,
                                            const Workers& workers,
                                            std::span<const Hit> all_hits = {});

// Coherent scatterers of those pieces of scattering.edges that the sonar sees, without variance:
//   a = |R| f dl/(2 pi) sinc(2 dl cos(beta)/lambda),   f = fringe_diffraction,
// with the angle beta between edge and ray, and R = coherent_reflection of the face that is seen
// more nearly at normal incidence. They are what kirchhoff_scatterers leaves out. Pieces are those
// of pieces_of. Edges whose exterior angle on the side of the sonar is below pi give none.
std::vector<Scatterer> edge_scatterers(const PlacedWorld& view, const SurfaceScattering& scattering,
                                       const Workers& workers);

// Coherent scatterers of the objects that ring, without variance: of a sphere one at its center for
// each tap, of a cylinder one for each tap and piece dl of its axis, times dl sinc(2 dl cos(beta)/
// lambda) with the angle beta between axis and ray. A place is heard if the straight ray to it
// meets its object first; otherwise it is added to `hidden`, if given. The near field of a body is
// left out: spreading, direction and range are those of the center or axis.
std::vector<Scatterer> elastic_scatterers(const PlacedWorld& placed, const Sonar& sonar,
                                          const Water& water, const Workers& workers,
                                          std::vector<HiddenTarget>* hidden = nullptr);

// Point targets and fish.
struct PointScatterers {
  std::vector<Scatterer> heard;
  std::vector<HiddenTarget> hidden;
};

// Each hit behind the first one of a ray gives the scatterer that surface_scatterers would compute
// for it; coherent echoes are left out. The first of these hits is hidden only by the instance that
// the ray met first. `instances`: their number in the world. The caller applies the extinction by
// volumes (attenuate).
HiddenEchoes hidden_echoes(const Fan& fan, std::span<const Hit> hits, const FanHitsBehind& behind,
                           const PointScatterers& points, const SurfaceScattering& scattering,
                           std::size_t instances, const Workers& workers);

}  // namespace ensonify
