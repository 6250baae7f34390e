// Marks functions that are compiled for the host and, with nvcc, also for the device, and loops
// whose arrays must stay in the device's registers.
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
