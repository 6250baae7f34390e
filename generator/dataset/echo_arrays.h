// The arrays of a ping's echoes: their dtypes, and encoding them.
//
//   kNpyScatterer  encode_scatterers   the structured array of scatterers/*.npy
//   kNpyVia  encode_via                that of scatterers/*_via.npy
//   kNpyElevation  encode_elevation    that of elevation/*.npy
#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <string>

#include "core/scatterers.h"
#include "core/vec.h"

namespace ensonify {

// The dtype of scatterers/*.npy as it stands in the header: fields packed, in the order of
// docs and contract; 82 bytes an element.
extern const char* const kNpyScatterer;
inline constexpr std::size_t kScattererBytes = 82;
// That of scatterers/*_via.npy.
extern const char* const kNpyVia;
// That of elevation/*.npy: the members of ElevationEcho, as they lie in memory.
extern const char* const kNpyElevation;

// `amplitudes` are the drawn ones, one per scatterer; the pose transforms positions to the world.
// Needs amplitudes.size() == scatterers.size(). Order is kept.
std::string encode_scatterers(const ScattererList& scatterers,
                              std::span<const std::complex<float>> amplitudes,
                              const Pose& sonar_in_world);

// Scatterer::via of each, in the order of the list.
std::string encode_via(const ScattererList& scatterers);

std::string encode_elevation(std::span<const ElevationEcho> echoes);

}  // namespace ensonify
