#define ENSONIFY_LEVEL sse4
#define ENSONIFY_VECTOR_BYTES 16
#include "synthesis/cpu/kernels.inl"
