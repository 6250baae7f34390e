// The table of one level: included by kernels_LEVEL.cpp with ENSONIFY_LEVEL (a namespace) and
// ENSONIFY_VECTOR_BYTES set.
#include "synthesis/cpu/kernels.h"

namespace ensonify::ENSONIFY_LEVEL {
namespace {

constexpr int kLanes = ENSONIFY_VECTOR_BYTES / 4;
typedef float Vector __attribute__((vector_size(ENSONIFY_VECTOR_BYTES)));
// The same at any address.
typedef float LooseVector
    __attribute__((vector_size(ENSONIFY_VECTOR_BYTES), aligned(4), may_alias));

inline Vector load(const float* p) { return *reinterpret_cast<const LooseVector*>(p); }
inline void store(float* p, Vector v) { *reinterpret_cast<LooseVector*>(p) = v; }

// One complex number in all pairs of lanes.
typedef double Pair __attribute__((may_alias, aligned(4)));
typedef double PairVector __attribute__((vector_size(ENSONIFY_VECTOR_BYTES)));
inline Vector pairs(const float* p) {
  const double pair = *reinterpret_cast<const Pair*>(p);
#if ENSONIFY_VECTOR_BYTES == 64
  const PairVector v = {pair, pair, pair, pair, pair, pair, pair, pair};
#elif ENSONIFY_VECTOR_BYTES == 32
  const PairVector v = {pair, pair, pair, pair};
#else
  const PairVector v = {pair, pair};
#endif
  return reinterpret_cast<Vector>(v);
}

#include "synthesis/cpu/kernels_draw.inl"
#include "synthesis/cpu/kernels_grid.inl"
#include "synthesis/cpu/kernels_mix.inl"

}  // namespace

extern const Kernels kKernels;
const Kernels kKernels = {draw_normals, apply_path,   place,   deposit, add_scaled, widen,
                          narrow,       multiply,     multiply_add, product, fold,  unfold,
                          combine,      store_complex, store_power, add_square};

}  // namespace ensonify::ENSONIFY_LEVEL
