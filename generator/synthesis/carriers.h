// Groups of beams with carriers of their own (TransmitGroups::frequency_hz).
//
//   shift_carriers        a sonar at other frequencies
//   absorb  more_absorption_db_m   absorption at another frequency
//   make_carrier_backend  a backend for each carrier, as one
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "synthesis/backend.h"

namespace ensonify {

// Adds to the carriers; the pulse keeps its shape about them.
void shift_carriers(Sonar& sonar, double by_hz);

// Adds absorption to echoes that have some, `more_db_m` [beams] by the beam cell of arrival:
// multiplies gains by 10^(-more c (delay - lag)/20), and energies of volumes in sample n by
// 10^(-more c n/(10 b)). A path that is bent counts with the sound speed of the instrument.
void absorb(ScattererList& list, const Water& water, std::span<const double> more_db_m);
void absorb(VolumeEcho& volume, const Sonar& sonar, const Water& water,
            std::span<const double> more_db_m);

// [beams]: absorption that a group hears, or each beam's own group if `group` is -1, beyond what
// the echoes in each beam cell have: those of the cell's group, or those of the sonar's carrier.
// Empty if water has the same for all.
std::vector<double> more_absorption_db_m(const Sonar& sonar, const Water& water, int group = -1);

using MakeCarrier = std::function<std::unique_ptr<Backend>(const SynthesisSetup&)>;

// make(setup) unless groups have carriers of their own. Otherwise the beams of a group hear all
// echoes at its carrier and with its absorption: all groups are synthesized, each by a backend of
// its own, which makes all beams. Scatterers have the same amplitudes in all groups. Volumes have
// amplitudes of their own in each, as bands that do not overlap have. Echoes come with the
// absorption of the group of their beam cell. It returns pressure even if only levels are needed,
// and has no moment_sums.
std::unique_ptr<Backend> make_carrier_backend(const SynthesisSetup& setup, const MakeCarrier& make);

}  // namespace ensonify
