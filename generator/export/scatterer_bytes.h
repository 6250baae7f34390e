// A scatterer of scatterers/*.npy. Private to export/.
//
//   StoredScatterer  scatterer_at
#pragma once

#include <cstdint>
#include <string_view>

#include "core/vec.h"
#include "dataset/echo_arrays.h"
#include "formats/bytes.h"

namespace ensonify {

struct StoredScatterer {
  Vec3 in_world;
  double intensity = 0;  // |amplitude gain|^2: the squared pressure for a source of 1 Pa m
  std::uint32_t instance = 0;
};

// Needs kScattererBytes bytes (echo_arrays.h).
inline StoredScatterer scatterer_at(std::string_view bytes) {
  constexpr std::size_t kAmplitude = 20, kGain = 40, kInstance = 52, kPosition = 58;
  const double re = value_at<float>(bytes, kAmplitude);
  const double im = value_at<float>(bytes, kAmplitude + sizeof(float));
  const double gain = value_at<float>(bytes, kGain);
  const auto place = [&](std::size_t axis) {
    return value_at<double>(bytes, kPosition + axis * sizeof(double));
  };
  return {{place(0), place(1), place(2)},
          (re * re + im * im) * gain * gain,
          value_at<std::uint32_t>(bytes, kInstance)};
}

}  // namespace ensonify
