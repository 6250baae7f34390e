// Sums over the elements of an array.

// The fractional part of turns as fixed-point number, in units of 2^-32.
inline std::int32_t fixed_turns(double turns) {
  // The factor is a little less than 2^32, so that half a turn does not overflow.
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

// The value of echo i at every element of a group, and its argument of the kernel's polynomials.
inline void element_values(float first_element, const PathArrays* paths, int i, float value_re,
                           float value_im, float per_reach, float* __restrict re,
                           float* __restrict im, float* __restrict place) {
  const std::int32_t turns = paths->turns[i], slope = paths->slope[i];
  const float b0 = paths->bend[0][i], b1 = paths->bend[1][i], b2 = paths->bend[2][i];
  const float s0 = paths->shift[0][i] * per_reach, s1 = paths->shift[1][i] * per_reach;
  const float offset = paths->offset[i] * per_reach;
  for (int l = 0; l < kGroupElements; ++l) {
    const float x = first_element + static_cast<float>(l);
    const auto fixed = static_cast<std::int32_t>(static_cast<std::uint32_t>(turns) +
                                                 static_cast<std::uint32_t>(l) *
                                                     static_cast<std::uint32_t>(slope));
    const float phase = static_cast<float>(fixed) * 0x1p-32f + x * x * (b0 + x * (b1 + x * b2));
    float sine, cosine;
    turn_sine_cosine(phase, &sine, &cosine);
    re[l] = value_re * cosine - value_im * sine;
    im[l] = value_re * sine + value_im * cosine;
    place[l] = offset + x * (s0 + x * s1);
  }
}

inline void add_to(float* p, Vector v) { store(p, load(p) + v); }

// The elements of a grid point are adjacent in memory. An echo therefore writes a contiguous range,
// and the next echo writes vectors with the same alignment.
template <int kTerms>
inline void deposit_terms(double first_element, const PathArrays* paths, const float* re,
                          const float* im, int count, const GroupKernel* kernel, float* grid) {
  constexpr int kPoint = 2 * kGroupElements;
  const auto to_first = static_cast<float>(first_element);
  alignas(64) float value_re[kGroupElements], value_im[kGroupElements], place[kGroupElements];
  for (int i = 0; i < count; ++i) {
    if (re[i] == 0 && im[i] == 0) continue;
    element_values(to_first, paths, i, re[i], im[i], kernel->per_reach, value_re, value_im, place);
    float* begin = grid + static_cast<std::int64_t>(paths->first[i] + kHalo) * kPoint;
    for (int v = 0; v < kGroupElements; v += kLanes) {
      const Vector x = load(place + v), square = x * x;
      const Vector a = load(value_re + v), b = load(value_im + v);
      const float* c = kernel->coefficient;
      float* front = begin + v;
      float* back = front + (kernel->width - 1) * kPoint;
      for (; front <= back; front += kPoint, back -= kPoint, c += 2 * kTerms) {
        Vector even = Vector{} + c[0], odd = Vector{} + c[1];
#pragma GCC unroll 8
        for (int k = 1; k < kTerms; ++k) {
          even = even * square + c[2 * k];
          odd = odd * square + c[2 * k + 1];
        }
        const Vector w = even + odd * x;
        add_to(front, a * w);
        add_to(front + kGroupElements, b * w);
        if (front == back) break;
        const Vector z = even - odd * x;
        add_to(back, a * z);
        add_to(back + kGroupElements, b * z);
      }
    }
  }
}

void array_deposit(double first_element, const PathArrays* paths, const float* re, const float* im,
                   int count, const GroupKernel* kernel, float* grid) {
  const auto run = kernel->terms <= 3   ? deposit_terms<3>
                   : kernel->terms == 4 ? deposit_terms<4>
                   : kernel->terms == 5 ? deposit_terms<5>
                   : kernel->terms == 6 ? deposit_terms<6>
                   : kernel->terms == 7 ? deposit_terms<7>
                                        : deposit_terms<8>;
  run(first_element, paths, re, im, count, kernel, grid);
}

void widen_elements(const float* __restrict grid, int points, int halo, int first, int count,
                    double* __restrict out) {
  constexpr int kPoint = 2 * kGroupElements;
  const float* inner = grid + halo * kPoint + first;
  for (int i = 0; i < points; ++i) {
    for (int l = 0; l < count; ++l) {
      double* to = out + 2 * (static_cast<std::int64_t>(l) * points + i);
      to[0] = static_cast<double>(inner[i * kPoint + l]);
      to[1] = static_cast<double>(inner[i * kPoint + kGroupElements + l]);
    }
  }
  for (int l = 0; l < count; ++l) {
    double* to = out + 2 * static_cast<std::int64_t>(l) * points;
    for (int i = -halo; i < 0; ++i) {
      to[2 * (points + i)] += static_cast<double>(inner[i * kPoint + l]);
      to[2 * (points + i) + 1] += static_cast<double>(inner[i * kPoint + kGroupElements + l]);
    }
    for (int i = points; i < points + halo; ++i) {
      to[2 * (i - points)] += static_cast<double>(inner[i * kPoint + l]);
      to[2 * (i - points) + 1] += static_cast<double>(inner[i * kPoint + kGroupElements + l]);
    }
  }
}

// One element's record at the delay of a beam, interpolated from neighboring samples by the taps.
inline void delayed_record(const BeamElement& e, int samples, float* __restrict re,
                           float* __restrict im) {
  for (int t = 0; t < samples; t += kLanes) {
    Vector sum_re = {}, sum_im = {};
    const float* even = e.even + t;
    const float* odd = e.odd + t;
#pragma GCC unroll 8
    for (int k = 0; k < kBeamTaps / 2; ++k) {
      sum_re += e.tap[2 * k] * load(even + k);
      sum_im += e.tap[2 * k] * load(even + e.to_im + k);
      sum_re += e.tap[2 * k + 1] * load(odd + k);
      sum_im += e.tap[2 * k + 1] * load(odd + e.to_im + k);
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

// Sums whole vectors of samples [begin, end), kStep vectors at once. Returns the first sample left.
template <int kDegree, int kStep>
inline int nodes_in_steps(const NodeSum* sum, const float* t, int begin, int end, float* re,
                          float* im) {
  int i = begin;
  for (; i + kStep * kLanes <= end; i += kStep * kLanes) {
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
#pragma GCC unroll 8
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
  return i;
}

// Sums as many vectors at once as fit into the registers together with the coefficients.
template <int kDegree>
inline void nodes_of_degree(const NodeSum* sum, const float* t, int samples, float* re, float* im) {
  constexpr int kStep = ENSONIFY_VECTOR_BYTES == 64 ? 4 : 2;
  const int done = nodes_in_steps<kDegree, kStep>(sum, t, 0, samples, re, im);
  nodes_in_steps<kDegree, 1>(sum, t, done, samples, re, im);
}

void array_nodes(const NodeSum* sum, const float* t, int samples, float* re, float* im) {
  const auto run = sum->degree == 0   ? nodes_of_degree<0>
                   : sum->degree == 3 ? nodes_of_degree<3>
                                      : nodes_of_degree<5>;
  run(sum, t, samples, re, im);
}
