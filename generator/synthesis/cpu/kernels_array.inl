// Sums over the elements of an array.

// What is left of turns after whole ones, in fractions of 2^32.
inline std::int32_t fixed_turns(double turns) {
  // Half a turn must not overflow.
  return static_cast<std::int32_t>((turns - __builtin_rint(turns)) * 4294967040.0);
}

void array_paths(const GroupLine* line, const PointArrays* points, int count,
                 PathArrays* __restrict paths) {
  const double y = line->middle_m, d = line->spacing_m;
  const double per_m = line->turns_per_m, to_first = line->first_element;
  const double grid = line->points, edge_shift = 0.5 * line->width;
  const double shift_per_m = -2 * line->points_per_m;
  const double* __restrict range_m = points->range_m;
  const double* __restrict along_m = points->along_m;
  const double* __restrict turns = points->turns;
  const double* __restrict position = points->position;
  for (int i = 0; i < count; ++i) {
    const double r = range_m[i], along = along_m[i];
    const double square = y * y - 2 * y * along;
    const double from_group = __builtin_sqrt(r * r + square);
    const double longer_m = square / (from_group + r);
    const double inverse = 1 / from_group;
    const double m = (y - along) * inverse;
    const double across = (1 - m * m) * inverse;
    const double slope = per_m * d * m;
    paths->turns[i] = fixed_turns(turns[i] + per_m * longer_m + to_first * slope);
    paths->slope[i] = fixed_turns(slope);
    const double bend = per_m * d * d * across;
    const double step = d * inverse;
    paths->bend[0][i] = static_cast<float>(0.5 * bend);
    paths->bend[1][i] = static_cast<float>(-0.5 * bend * m * step);
    paths->bend[2][i] = static_cast<float>(-0.125 * bend * (1 - 5 * m * m) * step * step);
    const double x = position[i] + line->points_per_m * longer_m;
    const double edge = x - grid * __builtin_floor(x / grid) - edge_shift;
    const double begin = __builtin_ceil(edge);
    paths->first[i] = static_cast<std::int32_t>(begin);
    paths->offset[i] = static_cast<float>(2.0 * (begin - edge) - 1.0);
    paths->shift[0][i] = static_cast<float>(shift_per_m * d * m);
    paths->shift[1][i] = static_cast<float>(shift_per_m * 0.5 * d * d * across);
  }
}

// Sine and cosine of turns in [-1, 1].
inline void turn_sine_cosine(float turns, float* sine, float* cosine) {
  const float quarters = 4.0f * turns;
  const float whole = __builtin_rintf(quarters);
  sine_cosine(static_cast<std::int32_t>(whole), (quarters - whole) * 1.57079632679f, sine, cosine);
}

// What every element of a group makes of echo i, and by how much it hears it later.
inline void element_values(const ArrayGroup* group, const PathArrays* paths, int i, float value_re,
                           float value_im, float* __restrict re, float* __restrict im,
                           float* __restrict shift) {
  const std::int32_t turns = paths->turns[i], slope = paths->slope[i];
  const float b0 = paths->bend[0][i], b1 = paths->bend[1][i], b2 = paths->bend[2][i];
  const float s0 = paths->shift[0][i], s1 = paths->shift[1][i];
  const float to_first = static_cast<float>(group->first_element);
  for (int l = 0; l < kGroupElements; ++l) {
    const float x = to_first + static_cast<float>(l);
    const auto fixed = static_cast<std::int32_t>(static_cast<std::uint32_t>(turns) +
                                                 static_cast<std::uint32_t>(l) *
                                                     static_cast<std::uint32_t>(slope));
    const float phase = static_cast<float>(fixed) * 0x1p-32f + x * x * (b0 + x * (b1 + x * b2));
    float sine, cosine;
    turn_sine_cosine(phase, &sine, &cosine);
    const float a = group->response_re[l] * value_re - group->response_im[l] * value_im;
    const float b = group->response_re[l] * value_im + group->response_im[l] * value_re;
    re[l] = a * cosine - b * sine;
    im[l] = a * sine + b * cosine;
    shift[l] = x * (s0 + x * s1);
  }
}

template <int kVectors, int kOrder>
inline void array_deposit_order(const ArrayGroup* group, const PathArrays* paths, const float* re,
                                const float* im, int count, const GroupKernel* kernel, float* rows,
                                std::int64_t stride) {
  const auto at = [](const float* p, int v) {
    return *reinterpret_cast<const SpreadVector*>(p + v * kSpreadLanes);
  };
  alignas(64) float value_re[kGroupElements], value_im[kGroupElements], shift[kGroupElements];
  for (int i = 0; i < count; ++i) {
    element_values(group, paths, i, re[i], im[i], value_re, value_im, shift);
    const float t = paths->offset[i];
    const float* c = kernel->coefficient;
    // Horner's scheme for the value and its derivatives, over their factorials.
    SpreadVector term[kOrder + 1][kVectors] = {};
    for (int d = 0; d <= kernel->degree; ++d, c += kVectors * kSpreadLanes) {
#pragma GCC unroll 8
      for (int o = kOrder; o > 0; --o) {
#pragma GCC unroll 8
        for (int v = 0; v < kVectors; ++v) term[o][v] = term[o][v] * t + term[o - 1][v];
      }
#pragma GCC unroll 8
      for (int v = 0; v < kVectors; ++v) term[0][v] = term[0][v] * t + at(c, v);
    }
    float* row = rows + paths->first[i] + kHalo;
    for (int l = 0; l < group->count; ++l, row += 2 * stride) {
      const float e = shift[l];
#pragma GCC unroll 8
      for (int v = 0; v < kVectors; ++v) {
        SpreadVector sum = term[kOrder][v];
#pragma GCC unroll 8
        for (int o = kOrder - 1; o >= 0; --o) sum = sum * e + term[o][v];
        float* p = row + v * kSpreadLanes;
        *reinterpret_cast<SpreadVector*>(p) = at(p, 0) + value_re[l] * sum;
        p += stride;
        *reinterpret_cast<SpreadVector*>(p) = at(p, 0) + value_im[l] * sum;
      }
    }
  }
}

template <int kVectors>
inline void array_deposit_wide(const ArrayGroup* group, const PathArrays* paths, const float* re,
                               const float* im, int count, const GroupKernel* kernel, float* rows,
                               std::int64_t stride) {
  const auto run = kernel->order <= 1   ? array_deposit_order<kVectors, 1>
                   : kernel->order == 2 ? array_deposit_order<kVectors, 2>
                   : kernel->order == 3 ? array_deposit_order<kVectors, 3>
                                        : array_deposit_order<kVectors, 4>;
  run(group, paths, re, im, count, kernel, rows, stride);
}

void array_deposit(const ArrayGroup* group, const PathArrays* paths, const float* re,
                   const float* im, int count, const GroupKernel* kernel, float* rows,
                   std::int64_t stride) {
  const auto run = kernel->lanes == 8 ? array_deposit_wide<8 / kSpreadLanes>
                                      : array_deposit_wide<16 / kSpreadLanes>;
  run(group, paths, re, im, count, kernel, rows, stride);
}

void widen_planes(const float* __restrict re, const float* __restrict im, int points, int halo,
                  double* __restrict out) {
  for (int i = 0; i < points; ++i) {
    out[2 * i] = static_cast<double>(re[halo + i]);
    out[2 * i + 1] = static_cast<double>(im[halo + i]);
  }
  for (int i = 0; i < halo; ++i) {
    out[2 * (points - halo + i)] += static_cast<double>(re[i]);
    out[2 * (points - halo + i) + 1] += static_cast<double>(im[i]);
    out[2 * i] += static_cast<double>(re[halo + points + i]);
    out[2 * i + 1] += static_cast<double>(im[halo + points + i]);
  }
}

// One element's record where a beam wants it, taps of neighbouring samples added up.
inline void delayed_record(const BeamElement& e, int samples, float* __restrict re,
                           float* __restrict im) {
  for (int t = 0; t < samples; t += kLanes) {
    Vector sum_re = {}, sum_im = {};
#pragma GCC unroll 8
    for (int k = 0; k < kBeamTaps; ++k) {
      sum_re += e.tap[k] * load(e.re[k] + t);
      sum_im += e.tap[k] * load(e.im[k] + t);
    }
    store(re + t, sum_re);
    store(im + t, sum_im);
  }
}

void array_beam(const BeamElement* elements, int count, double first_element,
                const PathArrays* paths, int samples, float* __restrict re, float* __restrict im) {
  alignas(64) float part_re[kBeamBlock], part_im[kBeamBlock];
  const float to_first = static_cast<float>(first_element);
  for (int l = 0; l < count; ++l) {
    const BeamElement& e = elements[l];
    const float a = e.weight_re, b = e.weight_im;
    delayed_record(e, samples, part_re, part_im);
    if (paths == nullptr) {
      for (int t = 0; t < samples; ++t) {
        re[t] += a * part_re[t] - b * part_im[t];
        im[t] += a * part_im[t] + b * part_re[t];
      }
      continue;
    }
    const float x = to_first + static_cast<float>(l), xx = x * x;
    for (int t = 0; t < samples; ++t) {
      const auto fixed = static_cast<std::int32_t>(static_cast<std::uint32_t>(paths->turns[t]) +
                                                   static_cast<std::uint32_t>(l) *
                                                       static_cast<std::uint32_t>(paths->slope[t]));
      const float bend = paths->bend[0][t] + x * (paths->bend[1][t] + x * paths->bend[2][t]);
      float sine, cosine;
      turn_sine_cosine(static_cast<float>(fixed) * 0x1p-32f + xx * bend, &sine, &cosine);
      re[t] += a * (cosine * part_re[t] - sine * part_im[t]);
      im[t] += a * (cosine * part_im[t] + sine * part_re[t]);
    }
  }
}

void array_steer(const double* __restrict rows, std::int64_t stride,
                 const double* __restrict weight, const double* __restrict t, int bins,
                 double* __restrict out) {
  static_assert(kSteerDegree == 4);
  for (int i = 0; i < 2 * bins; ++i) {
    double sum = 0;
    const double x = t[i];
#pragma GCC unroll 11
    for (int k = 0; k < kSteerTaps; ++k) {
      const double* w = weight + 5 * k;
      sum += ((((w[0] * x + w[1]) * x + w[2]) * x + w[3]) * x + w[4]) * rows[k * stride + i];
    }
    out[i] = sum;
  }
}

// Whole vectors of samples, as many as registers hold beside the coefficients.
template <int kDegree>
inline void nodes_of_degree(const NodeSum* sum, const float* t, int samples, float* re, float* im) {
  constexpr int kStep = ENSONIFY_VECTOR_BYTES == 64 ? 4 : 2;
  for (int i = 0; i < samples; i += kStep * kLanes) {
    Vector sum_re[kStep], sum_im[kStep], x[kStep];
    for (int v = 0; v < kStep; ++v) {
      sum_re[v] = load(re + i + v * kLanes);
      sum_im[v] = load(im + i + v * kLanes);
      x[v] = load(t + i + v * kLanes);
    }
    const float* c = sum->coefficient;
    const float* from_re = sum->re + i;
    const float* from_im = sum->im + i;
    for (int k = 0; k < sum->taps; ++k, c += 2 * (kDegree + 1)) {
#pragma GCC unroll 4
      for (int v = 0; v < kStep; ++v) {
        Vector a = Vector{} + c[0], b = Vector{} + c[1];
#pragma GCC unroll 4
        for (int d = 1; d <= kDegree; ++d) {
          a = a * x[v] + c[2 * d];
          b = b * x[v] + c[2 * d + 1];
        }
        const Vector p = load(from_re + v * kLanes), q = load(from_im + v * kLanes);
        sum_re[v] += a * p;
        sum_re[v] -= b * q;
        sum_im[v] += a * q;
        sum_im[v] += b * p;
      }
      from_re += sum->stride;
      from_im += sum->stride;
    }
    for (int v = 0; v < kStep; ++v) {
      store(re + i + v * kLanes, sum_re[v]);
      store(im + i + v * kLanes, sum_im[v]);
    }
  }
}

void array_nodes(const NodeSum* sum, const float* t, int samples, float* re, float* im) {
  const auto run = sum->degree == 0 ? nodes_of_degree<0> : nodes_of_degree<3>;
  run(sum, t, samples, re, im);
}
