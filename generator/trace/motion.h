// Motion while the sound of one ping travels.
//
// Rays are traced with everything at its pose at transmission. Then each echo is corrected: it is
// scattered where its object is when the sound arrives there, and received where the sonar is when
// the echo arrives.
//
//   Movement  movement_of  rests     poses over one ping
//   Flight  direct_flight  bounced_flight   of one echo
//   move_echoes             a ping's echoes
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "core/sonar.h"
#include "world/path.h"
#include "world/pose_track.h"
#include "world/world.h"

namespace ensonify {

struct Movement {
  PoseTrack sonar;                                    // in the world
  std::vector<std::optional<PoseTrack>> object = {};  // by instance id; none: at rest
  Pose sent_from = sonar.at(0);
  Vec3 sent_velocity = sonar.velocity(0);
};

// From transmission at `time_s` until the last echo has arrived.
Movement movement_of(const World& world, const Path& body, const Pose& mount, double time_s,
                     const Sonar& sonar, const Water& water, const Workers& workers);
bool rests(const Movement& movement);

// Distances and unit vectors are those of the path of the sound in the world.
struct Flight {
  double delay_s = 0;
  double out_m = 0, in_m = 0;
  Vec3 departure, arrival;  // toward the scatterer, at transmission and at reception
  Pose heard_from;          // the sonar at reception
  double doppler = 0;       // d(sent)/d(heard) - 1, positive while closing
};

// The flight to a point X, given in the sonar's frame at transmission. The point moves with
// `object`, or rests if `object` is null. The delays solve
//   tau_out = |X(tau_out) - p(0)|/c,   tau = tau_out + |X(tau_out) - p(tau)|/c
// to 1e-15 s, where p is the position of the sonar. With the unit vectors u and w toward X from
// p(0) and p(tau), the velocity V of X at tau_out and the velocity v of the sonar,
//   1 + doppler = (1 - u.V/c)/(1 - u.v(0)/c) (1 + w.v(tau)/c)/(1 + w.V/c),
// so that doppler is exactly -tau'/(1 + tau') with tau' = d tau/d t0. The velocities are those of
// PoseTrack, exact to 1e-9 of c.
Flight direct_flight(const Movement& movement, const PoseTrack* object, Vec3 point_m,
                     double sound_speed_m_s);

// The flight of an echo over several surfaces. Its apparent source, received_path_m along the
// direction of arrival, rests.
Flight bounced_flight(const Movement& movement, const Scatterer& s, double sound_speed_m_s);

// Replaces delay, arrival, beam, received path, gain and Doppler of every echo by those of its
// flight, and for moving objects also the departure. The gain follows 1/(out in) 10^(-absorption
// (out + in)/20), two_direction_pattern in elevation, and the transmit pattern in the direction of
// departure. Drops echoes that arrive outside the beam cells, or outside the ranges at c tau/2; in
// elevation the fan limits only the transmission. Sorts the echoes again: origin[i] is the former
// index of item i.
struct MovedEchoes {
  ScattererList list;
  std::vector<std::uint32_t> origin;
};
MovedEchoes move_echoes(ScattererList list, const Movement& movement, const Sonar& sonar,
                        const Water& water, const Workers& workers);

}  // namespace ensonify
