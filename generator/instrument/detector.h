// From the time series of a ping to the levels that its detector puts out.
//
//   sub_band_borders    the sub-bands of looks
//   SubBands            their filters
//   DetectedPing  detected_levels_db   the levels, by the formulas of Detector
#pragma once

#include <complex>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/samples.h"
#include "core/sonar.h"
#include "instrument/front_end.h"
#include "synthesis/fft.h"

namespace ensonify {

// Borders of `looks` sub-bands as (f - f_c)/b, [looks + 1] from -1/2 to 1/2: each band holds the
// same share of the energy |S|^2 of the pulse (acoustics/pulse.h).
std::vector<double> sub_band_borders(const Sonar& sonar, int looks, int transform);

// Filters H_k between these borders, for at least two looks, with sum_k H_k^2 = 1, so that no power
// is lost. Around each inner border, over a quarter of the narrower of the two bands,
//   H_k = cos(pi/4 (1 + sin(pi u/2))), H_k+1 = sin(...), u from -1 to 1;
// steep edges would leave long tails behind strong echoes. Elsewhere H_k is 1 or 0.
class SubBands {
 public:
  SubBands(const Sonar& sonar, const Record& record);

  // power[n] = sum_k |p_k[n]|^2 of a beam [samples], which is silent beyond its record.
  void powers(std::span<const std::complex<float>> beam, std::span<double> power) const;

  // H_k in the order of the transform, [looks][transform].
  const std::vector<std::vector<double>>& filters() const { return filters_; }

 private:
  ComplexFft forward_, backward_;
  std::vector<std::vector<double>> filters_;
};

struct DetectedPing {
  const Sonar& sonar;  // with a detector
  const Record& record;
  const SubBands* sub_bands;  // null with one look
  PingMoment moment;
  std::span<const Series> further = {};  // bands 1, 2 ..., [beams x samples] each
};

// [samples x beams] in dB re 1 uPa from `pressure_pa` [beams x samples], band 0; kNoEnergyDb where
// there is no power. The mean over samples has the weights of an interval of `integrate` samples
// about each, in which every sample is one long; beyond the record there is nothing to average. The
// logarithm of no power counts as kNoEnergyDb and has no noise.
SampleArray<float> detected_levels_db(const DetectedPing& ping,
                                      std::span<const std::complex<float>> pressure_pa,
                                      const Workers& workers);

}  // namespace ensonify
