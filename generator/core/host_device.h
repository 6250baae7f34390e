// Marks functions that are compiled for the host and, under nvcc, for the device as well, and loops
// whose arrays shall stay in a device's registers.
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
