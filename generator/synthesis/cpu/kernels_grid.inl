// Deposit on the time grid and what surrounds the transforms.

template <int kChunks>
inline void deposit_chunks(const EchoArrays* echoes, std::int64_t begin, std::int64_t end,
                           const KernelPolynomial* kernel, const float* weight, int row_count,
                           float* rows, std::int64_t stride) {
  constexpr int kVectors = kChunks * 16 / kLanes;
  const int degree = kernel->degree;
  for (std::int64_t i = begin; i < end; ++i) {
    const Vector value = pairs(echoes->value + 2 * i);
    const float t = echoes->offset[i];
    const float* c = kernel->coefficient;
    Vector sum[kVectors];
#pragma GCC unroll 16
    for (int v = 0; v < kVectors; ++v) sum[v] = load(c + v * kLanes);
    for (int d = 0; d < degree; ++d) {
      c += kVectors * kLanes;
#pragma GCC unroll 16
      for (int v = 0; v < kVectors; ++v) sum[v] = sum[v] * t + load(c + v * kLanes);
    }
#pragma GCC unroll 16
    for (int v = 0; v < kVectors; ++v) sum[v] *= value;
    float* row = rows + 2 * (echoes->first[i] + kHalo);
    for (int r = 0; r < row_count; ++r, row += stride) {
#pragma GCC unroll 16
      for (int v = 0; v < kVectors; ++v) {
        const Vector w = load(weight + r * 16 + v * kLanes % 16);
        store(row + v * kLanes, load(row + v * kLanes) + w * sum[v]);
      }
    }
  }
}

void deposit(const EchoArrays* echoes, std::int64_t begin, std::int64_t end,
             const KernelPolynomial* kernel, const float* weight, int row_count, float* rows,
             std::int64_t stride) {
  if (kernel->chunks == 1) {
    deposit_chunks<1>(echoes, begin, end, kernel, weight, row_count, rows, stride);
  } else {
    deposit_chunks<2>(echoes, begin, end, kernel, weight, row_count, rows, stride);
  }
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
