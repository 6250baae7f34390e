#define ENSONIFY_LEVEL avx2
#define ENSONIFY_VECTOR_BYTES 32
#include "synthesis/cpu/kernels.inl"
