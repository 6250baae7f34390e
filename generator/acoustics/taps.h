// A frequency response as a few delayed echoes.
//
//   TapFit  fit_taps
//   product     of the responses of two sets of taps
#pragma once

#include <complex>
#include <functional>
#include <span>
#include <vector>

#include "core/elastic.h"

namespace ensonify {

struct TapFit {
  double frequency_hz = 0, bandwidth_hz = 0;  // the band is b wide, around the carrier
  double delay_min_s = 0, delay_max_s = 0;    // where taps may lie
  double error = 1e-3;  // share of the energy over the band that may be missing
  int most = 16;        // taps
};

// Taps whose sum follows `response` over the band, in order of their delays. There are fewer taps
// than `most` if these reach `error`. Taps are at least 0.6/b apart, so that the energy of the sum
// is nearly the sum of the energies. Orthogonal matching pursuit: each tap is placed where it
// correlates best with the remaining response, then all gains are solved again by least squares
// (Pati, Rezaiifar and Krishnaprasad, 27th Asilomar Conference, 1993). Empty if the response is 0.
std::vector<Tap> fit_taps(const std::function<std::complex<double>(double f_hz)>& response,
                          const TapFit& fit);

// The taps of a product of two responses, in order of their delays, without those below `least` of
// its energy. Taps with equal delays become one.
std::vector<Tap> product(std::span<const Tap> a, std::span<const Tap> b, double least = 1e-3);

}  // namespace ensonify
