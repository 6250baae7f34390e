// What nobody hears: echoes that surfaces keep from the sonar. Shadows and amodal masks are made
// from it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scatterers.h"

namespace ensonify {

struct HiddenEchoes {
  ScattererList list;                 // as they would be heard were nothing before them
  std::vector<std::uint32_t> caster;  // one each: the instance that alone hides it; 0: several do
  // By instance id: of the rays (point targets, fish) that meet it, the share that meets another
  // instance first. NaN: none meets it.
  std::vector<double> occlusion;
};

}  // namespace ensonify
