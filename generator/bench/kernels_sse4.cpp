#define ENSONIFY_LEVEL "sse4"
#define ENSONIFY_TABLE kSse4Kernels
#define ENSONIFY_LANES 4
#define ENSONIFY_MIX_ROWS 4
#define ENSONIFY_SUM_VECTORS 4
#include "bench/kernels.inl"
