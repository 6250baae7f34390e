#define ENSONIFY_LEVEL "avx2"
#define ENSONIFY_TABLE kAvx2Kernels
#define ENSONIFY_LANES 8
#define ENSONIFY_MIX_ROWS 4
#define ENSONIFY_SUM_VECTORS 4
#include "bench/kernels.inl"
