// What moves while the sound of one ping travels.
//
// Rays find what is hit with everything where it is at transmission. Then each echo is heard where
// the sonar is when it comes in, and thrown back where its object is when the sound gets there.
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

// From transmission at `time_s` until the last echo is in.
Movement movement_of(const World& world, const Path& body, const Pose& mount, double time_s,
                     const Sonar& sonar, const Water& water, const Workers& workers);
bool rests(const Movement& movement);

// Distances and unit vectors are those of the path of the sound in the world.
struct Flight {
  double delay_s = 0;
  double out_m = 0, in_m = 0;
  Vec3 departure, arrival;  // towards what throws the sound back: from where it is sent and heard
  Pose heard_from;          // the sonar when it comes in
  double doppler = 0;       // d(sent)/d(heard) - 1, closing above 0
};

// The point is given in the sonar's frame at transmission; `object` carries it, null: it rests.
// tau_out = |X(tau_out) - p(0)|/c and tau = tau_out + |X(tau_out) - p(tau)|/c, by iteration to
// 1e-15 s; with u and w towards X from where it is sent and heard, V its velocity then, v that of
// the sonar,
//   1 + doppler = (1 - u.V/c)/(1 - u.v(0)/c) (1 + w.v(tau)/c)/(1 + w.V/c)
// exactly -tau'/(1 + tau') with tau' = d tau/d t0. Velocities are PoseTrack's: 1e-9 of c.
Flight direct_flight(const Movement& movement, const PoseTrack* object, Vec3 point_m,
                     double sound_speed_m_s);

// The echo comes over mirrors: its apparent source, received_path_m along its arrival, rests.
Flight bounced_flight(const Movement& movement, const Scatterer& s, double sound_speed_m_s);

// Delay, arrival, sector, received path, gain and shift of every echo become those of its flight,
// the departure of what moves too. Gain: 1/(out in) 10^(-absorption (out + in)/20), and for the
// elevation pattern two_direction_pattern; the direction sent into weighs the transmit pattern.
// Echoes that come in outside the sectors, or at c tau/2 outside the ranges, are dropped; in
// elevation the fan binds only what is sent. Sorted again: origin[i] is where item i was before.
struct MovedEchoes {
  ScattererList list;
  std::vector<std::uint32_t> origin;
};
MovedEchoes move_echoes(const ScattererList& list, const Movement& movement, const Sonar& sonar,
                        const Water& water, const Workers& workers);

}  // namespace ensonify
