#include "synthesis/cpu/kernels.h"

#include "core/error.h"
#include "core/simd.h"

namespace ensonify {

namespace sse4 {
extern const Kernels kKernels;
}
namespace avx2 {
extern const Kernels kKernels;
}
namespace avx512 {
extern const Kernels kKernels;
}

const Kernels& kernels_of(SimdLevel level) {
  ENSONIFY_ASSERT(level <= best_simd_level());
  if (level == SimdLevel::avx512) return avx512::kKernels;
  return level == SimdLevel::avx2 ? avx2::kKernels : sse4::kKernels;
}

}  // namespace ensonify
