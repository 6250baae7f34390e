// Echoes over several surfaces of any shape: sound that is reflected or scattered more than once.
//
//   bounce_paths          the paths and their ids
//   bounced_off_surfaces  the scatterers of one ping
#pragma once

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "trace/bounce_ping.h"

namespace ensonify {

// All paths over two to bounces + 1 surfaces: `out` holds "specular" or "diffuse" for each surface,
// `back` is empty. With `walls`, the list also has the same paths through walls, whose `out` begins
// with "walls", and the paths that reach a single surface through walls.
std::vector<SoundPath> bounce_paths(int bounces, bool walls);

// The scatterers of all paths over two or more surfaces, in an order that does not depend on the
// workers. `hits`: the direct rays of the fan, from trace_fan.
//
// Each ray continues from the surface that it meets: as a specular reflection with R of
// coherent_reflection if the material is `kirchhoff`, and in one direction sampled from the cosine
// law, weighted by bistatic_strength. At each further surface that scatters, the path is connected
// to the sonar if nothing blocks the connection. Let W be the energy of a ray: its solid angle,
// times R^2 for each specular reflection and pi s(i, o) / (cos i cos o) for each sampled direction.
// Before absorption, the mean energy of an echo is W s(i, o) / (cos i r^2), where r is the length
// of the last piece. Veach, Robust Monte Carlo Methods for Light Transport Simulation (1997),
// chapter 8.
//
// Sound travels each path in both directions, which share amplitude and key. A path that scatters
// at both ends is found from both ends, so each find has half the energy. A path that begins with
// specular reflections is found only from that end. A path out over specular reflectors to a
// surface that scatters, and back over the same reflectors, has the energy W R^2 s(i, i) J / cos i,
// where J = dOmega / dA is the spreading of its ray tube. Paths over specular reflectors alone are
// sums over parts of the fan's cells, as in kirchhoff_scatterers. They follow geometrical acoustics
// up to the last reflector, which contributes (i / lambda) R sqrt(dOmega dA) / r (Ling, Chou and
// Lee, IEEE Trans. Antennas Propag. 37, 1989). The weight of a part depends on the sine of the
// angle between its ray behind the last reflector and the direction to the sonar: it is 1 up to
// 0.15 and falls to 0 at 0.5. Paths that leave over one chain of specular reflectors and return
// over another one are not found.
//
// Where a material is a wall, its response replaces the reflection coefficient, and if it has water
// inside, sound also passes straight through it. A wall that sound passes through does not count as
// a surface of the path. Up to the first surface that scatters, both reflection and passage are
// followed. After that surface, one of them is chosen by its energy.
//
// The elevation pattern uses both directions, and the transmit pattern uses the departure.
// `instance` and position of an echo are those of the last surface that scattered it, or of the
// last reflector if no surface did; `via` names the instances of all others in the order of the
// sound.
std::vector<Scatterer> bounced_off_surfaces(const BouncePing& ping, const Fan& fan,
                                            std::span<const Hit> hits, const Workers& workers);

}  // namespace ensonify
