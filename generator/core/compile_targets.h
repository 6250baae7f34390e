// Marks on functions that say for which processors they are compiled.
//
//   ENSONIFY_HD              for the host and, with nvcc, also for the device
//   ENSONIFY_UNROLL          a loop whose arrays must stay in the device's registers
//   ENSONIFY_VECTOR_CLONES   once for each width of vectors of the host
#pragma once

#if defined(__CUDACC__)
#define ENSONIFY_HD __host__ __device__
#else
#define ENSONIFY_HD
#endif

#if defined(__CUDA_ARCH__)
#define ENSONIFY_UNROLL _Pragma("unroll")
#else
#define ENSONIFY_UNROLL
#endif

// The clone is chosen when the program starts. Operations are not fused (-ffp-contract=off): all
// clones give the same bits. Sanitized programs, built by clang, have only the plain function.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ENSONIFY_VECTOR_CLONES \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define ENSONIFY_VECTOR_CLONES
#endif
