// Deposit on the time grid and what surrounds the transforms.

// At most 8 floats: wider ones cross a cache line with every access, and gain nothing.
constexpr int kSpreadLanes = kLanes < 8 ? kLanes : 8;
typedef float SpreadVector __attribute__((vector_size(4 * kSpreadLanes), aligned(4), may_alias));

// One complex number in all pairs of lanes.
inline SpreadVector pairs(const float* p) {
  typedef double Pair __attribute__((may_alias, aligned(4)));
  typedef double PairVector __attribute__((vector_size(4 * kSpreadLanes)));
  const double pair = *reinterpret_cast<const Pair*>(p);
#if ENSONIFY_VECTOR_BYTES >= 32
  const PairVector v = {pair, pair, pair, pair};
#else
  const PairVector v = {pair, pair};
#endif
  return reinterpret_cast<SpreadVector>(v);
}

template <int kChunks>
inline void deposit_chunks(const EchoArrays* echoes, std::int64_t begin, std::int64_t end,
                           const KernelPolynomial* kernel, const float* weight, int row_count,
                           float* rows, std::int64_t stride) {
  constexpr int kVectors = kChunks * 8 / kSpreadLanes;
  const int degree = kernel->degree;
  const auto at = [](const float* p, int v) {
    return *reinterpret_cast<const SpreadVector*>(p + v * kSpreadLanes);
  };
  for (std::int64_t i = begin; i < end; ++i) {
    const SpreadVector value = pairs(echoes->value + 2 * i);
    const float t = echoes->offset[i];
    const float* c = kernel->coefficient;
    SpreadVector sum[kVectors];
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) sum[v] = at(c, v);
    for (int d = 0; d < degree; ++d) {
      c += kVectors * kSpreadLanes;
#pragma GCC unroll 8
      for (int v = 0; v < kVectors; ++v) sum[v] = sum[v] * t + at(c, v);
    }
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) sum[v] *= value;
    float* row = rows + 2 * (echoes->first[i] + kHalo);
    for (int r = 0; r < row_count; ++r, row += stride) {
      const SpreadVector w = pairs(weight + 2 * r);
#pragma GCC unroll 8
      for (int v = 0; v < kVectors; ++v) {
        *reinterpret_cast<SpreadVector*>(row + v * kSpreadLanes) = at(row, v) + w * sum[v];
      }
    }
  }
}

void deposit(const EchoArrays* echoes, std::int64_t begin, std::int64_t end,
             const KernelPolynomial* kernel, const float* weight, int row_count, float* rows,
             std::int64_t stride) {
  const auto run = kernel->chunks == 1   ? deposit_chunks<1>
                   : kernel->chunks == 2 ? deposit_chunks<2>
                   : kernel->chunks == 3 ? deposit_chunks<3>
                                         : deposit_chunks<4>;
  run(echoes, begin, end, kernel, weight, row_count, rows, stride);
}

void add_scaled(const float* __restrict weight, const float* __restrict cells, int count,
                float* __restrict row) {
  const float even = weight[0], odd = weight[1];
  for (int i = 0; i < count; i += 2) {
    row[i] += even * cells[i];
    row[i + 1] += odd * cells[i + 1];
  }
}

void widen(const float* __restrict row, int points, int halo, double* __restrict out) {
  const float* inner = row + 2 * halo;
  for (int i = 0; i < 2 * points; ++i) out[i] = static_cast<double>(inner[i]);
  for (int i = 0; i < 2 * halo; ++i) {
    out[2 * (points - halo) + i] += static_cast<double>(row[i]);
    out[i] += static_cast<double>(inner[2 * points + i]);
  }
}

void narrow(const double* __restrict row, int count, float* __restrict re, float* __restrict im) {
  for (int i = 0; i < count; ++i) {
    re[i] = static_cast<float>(row[2 * i]);
    im[i] = static_cast<float>(row[2 * i + 1]);
  }
}

void multiply(const double* __restrict a, const double* __restrict f, int count,
              double* __restrict out) {
  for (int i = 0; i < count; ++i) {
    out[2 * i] = a[2 * i] * f[2 * i] - a[2 * i + 1] * f[2 * i + 1];
    out[2 * i + 1] = a[2 * i] * f[2 * i + 1] + a[2 * i + 1] * f[2 * i];
  }
}

void multiply_add(const double* __restrict a, const double* __restrict f, int count,
                  double* __restrict out) {
  for (int i = 0; i < count; ++i) {
    out[2 * i] += a[2 * i] * f[2 * i] - a[2 * i + 1] * f[2 * i + 1];
    out[2 * i + 1] += a[2 * i] * f[2 * i + 1] + a[2 * i + 1] * f[2 * i];
  }
}
