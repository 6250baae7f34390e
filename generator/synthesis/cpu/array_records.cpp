#include "synthesis/cpu/array_records.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "acoustics/propagation.h"
#include "core/units.h"
#include "synthesis/cpu/gridding.h"
#include "synthesis/draw.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// The shares of the tolerance for the kernel, for its polynomials, and for the ends of the kernel
// that are lost at elements away from a group's middle.
constexpr double kSpreadShare = 0.3, kPolynomialShare = 0.2, kLostShare = 0.2;
constexpr double kFurthestReach = 1.8;
// The largest error of a path's expansion, in turns of the carrier.
constexpr double kPathTurns = 1e-6;

constexpr double kTapBeta = 2.30 * kBeamTaps;

constexpr int kWidenedAtOnce = 4;  // elements

std::size_t grid_floats(const ArrayPlan& plan) {
  return std::size_t(plan.spread.points + 2 * kHalo) * 2 * kGroupElements;
}

// The grid of one group's elements, [halo + points + halo][re, im][kGroupElements].
struct GroupGrid {
  int first, count;  // elements
  GroupLine line;
  float* points;
  bool has_echoes = false;
};

// Deposits one point for one element at a time. It is so near that polynomials do not represent its
// paths to the elements.
void deposit_near(const ArrayPlan& plan, const Kernels& kernels, const PointArrays& point, float re,
                  float im, PathArrays& paths, GroupGrid& grid) {
  const GroupKernel& kernel = plan.kernel;
  for (int l = 0; l < grid.count; ++l) {
    const GroupLine line = plan.line(grid.first + l, 1, grid.line.turns_per_m);
    kernels.array_paths(&line, &point, 1, &paths);
    const Complex value = Complex(re, im) * std::polar(1.0, paths.turns[0] * 0x1p-32 * 2 * kPi);
    float* at = grid.points + std::size_t(paths.first[0] + kHalo) * 2 * kGroupElements + l;
    for (int tap = 0; tap < kernel.width; ++tap, at += 2 * kGroupElements) {
      const Complex part = value * group_kernel_at(kernel, tap, paths.offset[0]);
      at[0] += static_cast<float>(part.real());
      at[kGroupElements] += static_cast<float>(part.imag());
    }
  }
}

// `re` and `im` are scratch: the values of near points are set to 0.
void deposit_chunk(const ArrayPlan& plan, const Kernels& kernels, const PointArrays& points,
                   float* re, float* im, int count, PathArrays& paths, GroupGrid& grid) {
  for (int i = 0; i < count; ++i) {
    if (points.range_m[i] >= plan.exact_range_m) continue;
    const PointArrays near = {points.range_m + i, points.along_m + i, points.turns + i,
                              points.position + i};
    deposit_near(plan, kernels, near, re[i], im[i], paths, grid);
    re[i] = im[i] = 0;
  }
  kernels.array_paths(&grid.line, &points, count, &paths);
  kernels.array_deposit(grid.line.first_element, &paths, re, im, count, &plan.kernel, grid.points);
  grid.has_echoes = true;
}

void deposit_scatterers(const ArrayPlan& plan, const Kernels& kernels, const ArrayEchoes& echoes,
                        PointChunk& chunk, GroupGrid& grid) {
  for (std::size_t first = 0; first < echoes.count; first += kPointChunk) {
    const int count = static_cast<int>(std::min<std::size_t>(kPointChunk, echoes.count - first));
    std::copy_n(echoes.re.data() + first, count, chunk.re);
    std::copy_n(echoes.im.data() + first, count, chunk.im);
    const PointArrays points = {echoes.range_m.data() + first, echoes.along_m.data() + first,
                                echoes.turns.data() + first, echoes.position.data() + first};
    deposit_chunk(plan, kernels, points, chunk.re, chunk.im, count, chunk.paths, grid);
  }
}

// Fills the chunk with those samples [first, first + size) of a beam cell in which volumes have
// energy, and returns their number.
int gather_cells(const ArrayPlan& plan, const Kernels& kernels, const PingTask& task, int beam,
                 int first, int size, PointChunk& chunk) {
  const Sonar& sonar = plan.setup.sonar;
  const double u = std::sin(beam_azimuth_rad(sonar, beam));
  const double factor = source_pressure_pa_m(sonar) *
                        element_pattern(u, sonar.array->element_width_m,
                                        wavelength_m(plan.setup.sonar, plan.setup.water));
  alignas(64) float rms[kPointChunk];
  int count = 0;
  for (int n = first; n < first + size; ++n) {
    const double energy = total_energy(task.volumes, std::size_t(beam) * plan.samples() + n);
    if (energy == 0) continue;
    const double range_m = focus_range_m(sonar, plan.setup.water, n);
    chunk.range_m[count] = range_m;
    chunk.along_m[count] = range_m * u;
    chunk.turns[count] = 0;
    chunk.position[count] = static_cast<double>(n) * plan.spread.points / plan.bins();
    chunk.key_low[count] = static_cast<std::uint32_t>(n);
    chunk.key_high[count] = static_cast<std::uint32_t>(beam);
    rms[count++] = static_cast<float>(factor * std::sqrt(energy));
  }
  kernels.draw_normals(task.keys.volume, task.keys.speckle_ping, chunk.key_low, chunk.key_high,
                       count, chunk.re, chunk.im);
  for (int i = 0; i < count; ++i) {
    chunk.re[i] *= rms[i];
    chunk.im[i] *= rms[i];
  }
  return count;
}

void deposit_cells(const ArrayPlan& plan, const Kernels& kernels, const PingTask& task,
                   PointChunk& chunk, GroupGrid& grid) {
  for (int beam = 0; beam < plan.beams(); ++beam) {
    for (int n = 0; n < plan.samples(); n += kPointChunk) {
      const int size = std::min(kPointChunk, plan.samples() - n);
      const int count = gather_cells(plan, kernels, task, beam, n, size, chunk);
      if (count == 0) continue;
      deposit_chunk(plan, kernels, chunk.arrays(), chunk.re, chunk.im, count, chunk.paths, grid);
    }
  }
}

// Draws noise for the whole period, so that a delayed record has the same noise power at its ends.
void add_noise(const ArrayPlan& plan, const Kernels& kernels, const PingTask& task, int element,
               RecordScratch& scratch, Complex* spectrum) {
  if (task.noise_power_pa2 == 0 || plan.geometry.response[element] == Complex(0)) return;
  const double power = element_noise_power_pa2(plan.geometry, task.noise_power_pa2);
  const double rms = std::sqrt(power) / plan.bins();
  PointChunk& chunk = scratch.chunk;
  scratch.record.need(plan.bins());
  for (int n = 0; n < plan.bins(); n += kPointChunk) {
    const int count = std::min(kPointChunk, plan.bins() - n);
    for (int i = 0; i < count; ++i) {
      chunk.key_low[i] = static_cast<std::uint32_t>(n + i);
      chunk.key_high[i] = static_cast<std::uint32_t>(element);
    }
    kernels.draw_normals(task.keys.noise, task.keys.noise_ping, chunk.key_low, chunk.key_high,
                         count, chunk.re, chunk.im);
    for (int i = 0; i < count; ++i) scratch.record[n + i] = rms * Complex(chunk.re[i], chunk.im[i]);
  }
  plan.record_forward.run(scratch.record.data());
  for (int k = 0; k < plan.bins(); ++k) spectrum[k] += scratch.record[k];
}

// spectra: [count][bins].
void transform_group(const ArrayPlan& plan, const Kernels& kernels, const GroupGrid& grid,
                     RecordScratch& scratch, Complex* spectra) {
  const int bins = plan.bins(), half = bins / 2, points = plan.spread.points;
  if (!grid.has_echoes) {
    std::fill_n(spectra, std::size_t(grid.count) * bins, Complex(0));
    return;
  }
  scratch.spectrum.need(std::size_t(kWidenedAtOnce) * points);
  for (int l = 0; l < grid.count; ++l) {
    const int at_once = l % kWidenedAtOnce;
    if (at_once == 0) {
      kernels.widen_elements(grid.points, points, kHalo, l,
                             std::min(kWidenedAtOnce, grid.count - l),
                             as_doubles(scratch.spectrum.data()));
    }
    Complex* record = scratch.spectrum.data() + std::size_t(at_once) * points;
    Complex* spectrum = spectra + std::size_t(l) * bins;
    const double* filter = as_doubles(plan.filter.data());
    plan.grid_forward.run(record);
    kernels.multiply(as_doubles(record), filter, half, as_doubles(spectrum));
    kernels.multiply(as_doubles(record + points - half), filter + 2 * half, half,
                     as_doubles(spectrum + half));
    const Complex response = plan.geometry.response[grid.first + l];
    if (response == 1.0) continue;
    for (int k = 0; k < bins; ++k) spectrum[k] *= response;
  }
}

void gather_chunk(const ArrayPlan& plan, std::span<const Scatterer> items, double* range_m,
                  double* along_m, double* turns, double* position, float* factor,
                  PointChunk& chunk) {
  const Sonar& sonar = plan.setup.sonar;
  const double source_pa_m = source_pressure_pa_m(sonar),
               lambda_m = wavelength_m(plan.setup.sonar, plan.setup.water);
  const double width_m = sonar.array->element_width_m;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Scatterer& s = items[i];
    const double u = arrival_cosine(s);
    range_m[i] = s.received_path_m;
    along_m[i] = range_m[i] * u;
    turns[i] = -carrier_turns(sonar.frequency_hz, s.delay_s);
    position[i] = s.delay_s * plan.points_per_s();
    const double heard = width_m > 0 ? element_pattern(u, width_m, lambda_m) : 1.0;
    factor[i] = static_cast<float>(source_pa_m * heard) * s.gain;
    chunk.key_low[i] = static_cast<std::uint32_t>(s.key);
    chunk.key_high[i] = static_cast<std::uint32_t>(s.key >> 32);
  }
}

}  // namespace

BeamTaps make_beam_taps(const SynthesisSetup& setup, const ArrayGeometry& geometry) {
  BeamTaps taps;
  const int bins = setup.record.transform;
  // The window spans kBeamTaps half samples; k is one of `bins` bins.
  const WindowIntegral transform(kTapBeta, kBeamTaps, 200);
  for (int k = 0; k <= bins / 2; ++k) {
    taps.correction.push_back(
        1.0 / transform([&](double z) { return kPi * k * kBeamTaps * z / (2.0 * bins); }));
  }
  int furthest = 0;
  for (int j = 0; j < setup.sonar.beam_count; ++j) {
    const double azimuth = beam_azimuth_rad(setup.sonar, j);
    for (const double y : geometry.y_m) {
      const bool delayed = setup.sonar.array->steering == Steering::true_delay;
      const double delay_s =
          delayed ? steering_delay_s(y, azimuth, setup.water.sound_speed_m_s) : 0.0;
      const double at = 2 * delay_s * setup.sonar.bandwidth_hz;
      const int begin = static_cast<int>(std::ceil(at - kBeamTaps / 2.0));
      taps.begin.push_back(begin);
      for (int m = 0; m < kBeamTaps; ++m) {
        taps.tap.push_back(
            static_cast<float>(window(kTapBeta, (begin + m - at) / (kBeamTaps / 2.0))));
      }
      furthest = std::max({furthest, std::abs(begin), std::abs(begin + kBeamTaps)});
    }
  }
  taps.pad = furthest / 2 + 2;
  return taps;
}

double expansion_clearance_m(const SynthesisSetup& setup, int group_elements) {
  const ArrayReceiver& array = *setup.sonar.array;
  const double half = (group_elements - 1) / 2.0 * array.spacing_m;
  const double per_m = setup.sonar.frequency_hz / setup.water.sound_speed_m_s;
  const double nearest = std::pow(0.375 * per_m * std::pow(half, 5) / kPathTurns, 0.25);
  return std::max(nearest, 3 * half);
}

ElementGroups choose_groups(const SynthesisSetup& setup, const SpreadKernel& spread, int most) {
  const double points_per_s = setup.sonar.bandwidth_hz * spread.points / setup.record.transform;
  // In half grid points, like the kernel's offset.
  const double per_element =
      2 * points_per_s * setup.sonar.array->spacing_m / setup.water.sound_speed_m_s;
  ElementGroups groups;
  for (int size = most; size > 0 && groups.elements == 0; size /= 2) {
    groups.reach = 1 + per_element * (size - 1) / 2.0;
    const double lost = lost_beyond(spread, groups.reach) * spread.rounding_gain;
    const bool holds = groups.reach <= kFurthestReach && lost <= kLostShare * setup.tolerance;
    if (holds) groups.elements = size;
  }
  if (groups.elements == 0) return groups;
  groups.wide = fit_wide(spread, groups.reach, kPolynomialShare * setup.tolerance);
  const double end_m = (setup.sonar.array->elements - 1) / 2.0 * setup.sonar.array->spacing_m;
  groups.exact_range_m = end_m + expansion_clearance_m(setup, groups.elements);
  return groups;
}

double group_kernel_at(const GroupKernel& kernel, int tap, double offset) {
  const int pair = std::min(tap, kernel.width - 1 - tap);
  const float* c = kernel.coefficient + std::ptrdiff_t(pair) * kernel.terms * 2;
  const double x = offset * kernel.per_reach;
  double even = 0, odd = 0;
  for (int i = 0; i < kernel.terms; ++i) {
    even = even * x * x + c[2 * i];
    odd = odd * x * x + c[2 * i + 1];
  }
  return tap == pair ? even + odd * x : even - odd * x;
}

GroupLine ArrayPlan::line(int first_element, int count, double turns_per_m) const {
  const double c = setup.water.sound_speed_m_s;
  return {(geometry.y_m[first_element] + geometry.y_m[first_element + count - 1]) / 2,
          setup.sonar.array->spacing_m,
          turns_per_m,
          points_per_s() / c,
          -(count - 1) / 2.0,
          spread.points,
          spread.width};
}

std::shared_ptr<const ArrayPlan> make_array_plan(const SynthesisTables& tables,
                                                 const ArrayLimits& limits) {
  const SynthesisSetup& setup = tables.setup;
  const int bins = setup.record.transform, half = bins / 2;
  const double tolerance = kSpreadShare * setup.tolerance;
  SpreadKernel spread =
      choose_spread_kernel(tables.spectrum, -half, tolerance, limits.kernel_width);
  if (spread.points == 0) spread = choose_spread_kernel(tables.spectrum, -half, tolerance);
  if (spread.points == 0 || spread.width > 16) return nullptr;
  const int points = spread.points;
  auto plan = std::make_shared<ArrayPlan>(
      ArrayPlan{.setup = setup,
                .geometry = make_array_geometry(setup.sonar),
                .spread = std::move(spread),
                .kernel = {},
                .coefficient = {},
                .filter = std::vector<Complex>(bins),
                .taps = {},
                .grid_forward = ComplexFft(points, FftDirection::forward),
                .record_forward = ComplexFft(bins, FftDirection::forward),
                .record_backward = ComplexFft(bins, FftDirection::backward),
                .fine_backward = ComplexFft(2 * bins, FftDirection::backward)});
  ElementGroups groups = choose_groups(setup, plan->spread, limits.group_elements);
  if (groups.elements == 0) return nullptr;
  plan->group_elements = groups.elements;
  plan->coefficient = std::move(groups.wide.coefficient);
  plan->kernel = {plan->coefficient.data(), plan->spread.width, groups.wide.terms,
                  static_cast<float>(1 / groups.reach)};
  plan->exact_range_m = groups.exact_range_m;
  for (int k = -half; k < half; ++k) {
    plan->filter[k < 0 ? k + bins : k] =
        tables.spectrum[k + half] * plan->spread.correction[std::abs(k)];
  }
  plan->taps = make_beam_taps(setup, plan->geometry);
  return plan;
}

void gather_echoes(const ArrayPlan& plan, const Kernels& kernels, const PingTask& task,
                   EchoAmplitude amplitude, Pool<PointChunk>& pool, const Workers& workers,
                   ArrayEchoes& echoes) {
  const auto& items = task.scatterers->items;
  echoes.count = items.size();
  for (auto* buffer : {&echoes.range_m, &echoes.along_m, &echoes.turns, &echoes.position}) {
    buffer->need(echoes.count);
  }
  echoes.re.need(echoes.count);
  echoes.im.need(echoes.count);
  const bool drawn = amplitude == EchoAmplitude::drawn;
  workers.for_each((echoes.count + kPointChunk - 1) / kPointChunk, [&](std::size_t item) {
    auto chunk = pool.take();
    const std::size_t first = item * kPointChunk;
    const int count = static_cast<int>(std::min<std::size_t>(kPointChunk, echoes.count - first));
    alignas(64) float factor[kPointChunk];
    gather_chunk(plan, {items.data() + first, static_cast<std::size_t>(count)},
                 echoes.range_m.data() + first, echoes.along_m.data() + first,
                 echoes.turns.data() + first, echoes.position.data() + first, factor, *chunk);
    if (drawn) {
      kernels.draw_normals(task.keys.speckle, task.keys.speckle_ping, chunk->key_low,
                           chunk->key_high, count, chunk->re, chunk->im);
    }
    for (int i = 0; i < count; ++i) {
      const Scatterer& s = items[first + i];
      const float deviation = drawn ? s.standard_deviation : 0.0f;
      const float re = drawn ? chunk->re[i] : 0.0f, im = drawn ? chunk->im[i] : 0.0f;
      echoes.re[first + i] = factor[i] * amplitude_part(s.mean.real(), deviation, re);
      echoes.im[first + i] = factor[i] * amplitude_part(s.mean.imag(), deviation, im);
    }
  });
}

void element_spectra(const ArrayPlan& plan, const Kernels& kernels, const PingTask& task,
                     const ArrayEchoes& echoes, EchoAmplitude amplitude, Pool<RecordScratch>& pool,
                     const Workers& workers, AlignedBuffer<Complex>& spectra) {
  const bool drawn = amplitude == EchoAmplitude::drawn;
  const double turns_per_m = -plan.setup.sonar.frequency_hz / plan.setup.water.sound_speed_m_s;
  spectra.need(std::size_t(plan.elements()) * plan.bins());
  workers.for_each(plan.groups(), [&](std::size_t item) {
    auto scratch = pool.take();
    const int first = static_cast<int>(item) * plan.group_elements;
    const int count = std::min(plan.group_elements, plan.elements() - first);
    scratch->grid.need(grid_floats(plan));
    std::memset(scratch->grid.data(), 0, grid_floats(plan) * sizeof(float));
    GroupGrid grid{first, count, plan.line(first, count, turns_per_m), scratch->grid.data()};
    deposit_scatterers(plan, kernels, echoes, scratch->chunk, grid);
    if (drawn && !task.volumes.empty()) {
      deposit_cells(plan, kernels, task, scratch->chunk, grid);
    }
    Complex* of_group = spectra.data() + std::size_t(first) * plan.bins();
    transform_group(plan, kernels, grid, *scratch, of_group);
    for (int l = 0; drawn && l < count; ++l) {
      add_noise(plan, kernels, task, first + l, *scratch, of_group + std::size_t(l) * plan.bins());
    }
  });
}

void element_series(const ArrayPlan& plan, const AlignedBuffer<Complex>& spectra,
                    Pool<RecordScratch>& pool, const Workers& workers,
                    std::complex<float>* series) {
  workers.for_each(plan.elements(), [&](std::size_t element) {
    auto scratch = pool.take();
    scratch->record.need(plan.bins());
    std::copy_n(spectra.data() + element * plan.bins(), plan.bins(), scratch->record.data());
    plan.record_backward.run(scratch->record.data());
    for (int n = 0; n < plan.samples(); ++n) {
      series[element * plan.samples() + n] = std::complex<float>(scratch->record[n]);
    }
  });
}

std::uint64_t record_scratch_bytes(const ArrayPlan& plan) {
  return grid_floats(plan) * sizeof(float) +
         (kWidenedAtOnce * std::uint64_t(plan.spread.points) + 2 * std::uint64_t(plan.bins())) *
             sizeof(Complex) +
         sizeof(PointChunk);
}

}  // namespace ensonify
