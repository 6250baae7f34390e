#include "bench/kernels.h"

namespace ensonify {

KernelList supported_kernels() {
  KernelList list{{&kSse4Kernels, nullptr, nullptr}, 1};
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    list.table[list.count++] = &kAvx2Kernels;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw")) {
      list.table[list.count++] = &kAvx512Kernels;
    }
  }
  return list;
}

const KernelTable& best_kernels() {
  const KernelList list = supported_kernels();
  return *list.table[list.count - 1];
}

}  // namespace ensonify
