#define ENSONIFY_LEVEL avx512
#define ENSONIFY_VECTOR_BYTES 64
#include "synthesis/cpu/kernels.inl"
