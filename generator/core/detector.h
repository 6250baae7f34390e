// What turns the complex samples of a beam into the level that an instrument stores.
//
//   DetectorLaw  Detector   name_of: the words of the law in scenarios and files
//   detector_keys           its keys (core/keys.h)
#pragma once

#include <optional>

#include "core/keys.h"

namespace ensonify {

// What is averaged by `integrate`: |p|^2, |p| or the level in dB.
enum class DetectorLaw { power, amplitude, logarithm };

// From the samples p of a beam, after the ADC:
//   P = mean_q sum_k |p_qk|^2 + floor    p_qk: p in band q of `bands` and sub-band k of `looks`
//   V = law(P 10^(noise_db xi / 10))    xi standard normal, independent in each sample
//   level = law^-1(mean of V over `integrate` samples)
// Sub-bands are those of instrument/detector.h.
// Each band has speckle and noise of its own.
struct Detector {
  int looks = 1;                        // sub-bands
  std::optional<double> floor_db = {};  // dB re 1 uPa; absent: none
  double noise_db = 0;                  // standard deviation
  double integrate = 1;                 // samples; not a whole number: the ends count in part
  DetectorLaw law = DetectorLaw::power;
  int bands = 1;
};

inline const char* name_of(DetectorLaw law) {
  switch (law) {
    case DetectorLaw::power:
      return "power";
    case DetectorLaw::amplitude:
      return "amplitude";
    case DetectorLaw::logarithm:
      return "logarithm";
  }
  return "";
}

inline constexpr int kMostLooks = 1000;
inline constexpr int kMostBands = 16;

template <class Io, class Values>
void detector_keys(Io& io, Values& detector) {
  io.integer({"bands", "Bands",
              "Number of bands side by side, each bandwidth_hz wide, whose powers are averaged: a "
              "detector that is so many times faster than the samples it stores"},
             detector.bands, 1, kMostBands, written_if(detector.bands > 1));
  io.integer({"looks", "Looks",
              "Number of sub-bands whose powers are added, each with the same share of the "
              "pulse's energy; cells are that many times longer in range"},
             detector.looks, 1, kMostLooks);
  io.number({"floor_db", "Floor",
             "Power that the detector adds to that of each sample; left out: none", "dB re 1 µPa"},
            detector.floor_db, kLevelDb);
  io.number({"noise_db", "Noise",
             "Standard deviation of the noise of a logarithmic detector, independent in each "
             "sample before they are integrated"},
            detector.noise_db, from_to(0, 40));
  io.number({"integrate", "Integration",
             "Number of samples over which the detected values are averaged; not a whole number: "
             "the two at the ends count in part",
             "samples"},
            detector.integrate, from_to(1, 1e6));
  io.template choice<DetectorLaw>(
      {"law", "Law", "What is averaged over the samples of integrate: power, amplitude or level"},
      detector.law,
      {{"power", DetectorLaw::power},
       {"amplitude", DetectorLaw::amplitude},
       {"logarithm", DetectorLaw::logarithm}});
}

}  // namespace ensonify
