// The table of one level: included by kernels_LEVEL.cpp with ENSONIFY_LEVEL (a namespace) and
// ENSONIFY_VECTOR_BYTES set.
#if defined(__SSE2__)
#include <immintrin.h>
#endif

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

#include "synthesis/cpu/kernels_draw.inl"
#include "synthesis/cpu/kernels_grid.inl"
#include "synthesis/cpu/kernels_mix.inl"
// After those that it calls.
#include "synthesis/cpu/kernels_array.inl"

}  // namespace

extern const Kernels kKernels;
const Kernels kKernels = {draw_normals, apply_path,  place,         deposit,        add_scaled,
                          widen,        narrow,      multiply,      multiply_add,   product,
                          fold,         unfold,      combine,       store_complex,  store_power,
                          add_square,   array_paths, array_deposit, widen_elements, array_beam,
                          array_steer,  array_nodes};

}  // namespace ensonify::ENSONIFY_LEVEL
