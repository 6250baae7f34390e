#include "app/numerics.h"

namespace ensonify {

std::string numerics_name(SimdLevel used) {
  std::string name(simd_level_name(used));
  if (used != best_simd_level()) {
    name += " on " + std::string(simd_level_name(best_simd_level()));
  }
  return name;
}

}  // namespace ensonify
