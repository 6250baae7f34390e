// Products over beams, one tile of time at a time, and what writes the results.

// With 32 registers a block of 6 rows takes 4 vectors of columns, with 16 only 2.
constexpr int kColumns = ENSONIFY_VECTOR_BYTES == 64 ? 4 : 2;

void product(const float* __restrict packed, int row_count, int depth, const float* __restrict x,
             float* __restrict y) {
  for (int row = 0; row < row_count; row += kRowBlock, packed += kRowBlock * depth) {
    for (int column = 0; column < kTile; column += kColumns * kLanes) {
      Vector sum[kRowBlock][kColumns] = {};
      const float* a = packed;
      const float* b = x + column;
      for (int k = 0; k < depth; ++k, a += kRowBlock, b += kTile) {
        Vector bk[kColumns];
#pragma GCC unroll 4
        for (int v = 0; v < kColumns; ++v) bk[v] = load(b + v * kLanes);
#pragma GCC unroll 6
        for (int r = 0; r < kRowBlock; ++r) {
#pragma GCC unroll 4
          for (int v = 0; v < kColumns; ++v) sum[r][v] += a[r] * bk[v];
        }
      }
#pragma GCC unroll 6
      for (int r = 0; r < kRowBlock; ++r) {
#pragma GCC unroll 4
        for (int v = 0; v < kColumns; ++v) {
          store(y + (row + r) * kTile + column + v * kLanes, sum[r][v]);
        }
      }
    }
  }
}

void fold(const float* planes, std::int64_t stride, int segments, int nodes, float* even,
          float* odd) {
  const int length = kTile / segments;
  for (int c = 0; c < nodes / 2; ++c) {
    for (int s = 0; s < segments; ++s) {
      const float* front = planes + (std::int64_t{c} * segments + s) * stride;
      const float* back = planes + (std::int64_t{nodes - 1 - c} * segments + s) * stride;
      const int at = c * kTile + s * length;
      for (int i = 0; i < length; i += kLanes) {
        const Vector a = load(front + i), b = load(back + i);
        store(even + at + i, a + b);
        store(odd + at + i, a - b);
      }
    }
  }
}

void unfold(const float* even, const float* odd, int nodes, float* x) {
  for (int c = 0; c < nodes / 2; ++c) {
    for (int i = 0; i < kTile; i += kLanes) {
      const Vector a = load(even + c * kTile + i), b = load(odd + c * kTile + i);
      store(x + c * kTile + i, a + b);
      store(x + (nodes - 1 - c) * kTile + i, a - b);
    }
  }
}

void combine(const float* weight, int width, const float* x, float* out) {
  for (int column = 0; column < kTile; column += 4 * kLanes) {
    Vector sum[4] = {};
    for (int w = 0; w < width; ++w) {
#pragma GCC unroll 4
      for (int v = 0; v < 4; ++v) sum[v] += weight[w] * load(x + w * kTile + column + v * kLanes);
    }
#pragma GCC unroll 4
    for (int v = 0; v < 4; ++v) store(out + column + v * kLanes, sum[v]);
  }
}

void store_complex(const float* __restrict tile, const float* __restrict added, int count,
                   float* __restrict out) {
  const float* re = tile;
  const float* im = tile + kTile / 2;
  if (added == nullptr) {
    for (int i = 0; i < count; ++i) {
      out[2 * i] = re[i];
      out[2 * i + 1] = im[i];
    }
    return;
  }
  for (int i = 0; i < count; ++i) {
    out[2 * i] = re[i] + added[i];
    out[2 * i + 1] = im[i] + added[kTile / 2 + i];
  }
}

// The transforms leave rounding of either sign where there is nothing.
void store_power(const float* __restrict tile, int count, float* __restrict out) {
  for (int i = 0; i < count; ++i) out[i] = tile[i] > 0 ? tile[i] : 0.0f;
}

void add_square(const float* __restrict tile, int count, float* __restrict out) {
  const float* re = tile;
  const float* im = tile + kTile / 2;
  for (int i = 0; i < count; ++i) out[i] += re[i] * re[i] + im[i] * im[i];
}
