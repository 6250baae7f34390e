#define ENSONIFY_LEVEL "avx512"
#define ENSONIFY_TABLE kAvx512Kernels
#define ENSONIFY_LANES 16
#define ENSONIFY_MIX_ROWS 8
#define ENSONIFY_SUM_VECTORS 8
#include "bench/kernels.inl"
