// What echoes and cells of volumes contribute to the fast path: where on the time grid, and how
// much.
#include <algorithm>
#include <cmath>

#include "synthesis/cpu/node_sums.h"
#include "synthesis/draw.h"

namespace ensonify {
namespace {

constexpr int kChunk = EchoScratch::kCount;

void need(EchoBuffer& echoes, std::size_t count) {
  echoes.value.need(2 * count * static_cast<std::size_t>(echoes.draws));
  echoes.offset.need(count);
  echoes.first.need(count);
  if (!echoes.keeps_shift) return;
  echoes.delay.need(count);
  echoes.doppler.need(count);
}

void gather(std::span<const Scatterer> items, EchoScratch& s, EchoBuffer& echoes) {
  bool has_means = false, has_diffuse = false;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Scatterer& item = items[i];
    s.delay_s[i] = item.delay_s;
    s.key_low[i] = static_cast<std::uint32_t>(item.key);
    s.key_high[i] = static_cast<std::uint32_t>(item.key >> 32);
    s.mean_re[i] = item.mean.real();
    s.mean_im[i] = item.mean.imag();
    s.deviation[i] = item.standard_deviation;
    s.gain[i] = item.gain;
    has_means |= item.mean != 0.0f;
    has_diffuse |= item.standard_deviation != 0;
  }
  if (has_means) echoes.has_means.store(true, std::memory_order_relaxed);
  if (has_diffuse) echoes.has_diffuse.store(true, std::memory_order_relaxed);
}

// Computes the places of all echoes, and calls body(first, count, scratch) for every chunk.
template <class Body>
void for_each_chunk(const NodePlan& plan, const Kernels& kernels, const Sonar& sonar,
                    const ScattererList& list, Pool<EchoScratch>& pool, const Workers& workers,
                    EchoBuffer& echoes, Body&& body) {
  const std::size_t count = list.size();
  need(echoes, count);
  echoes.has_echoes = count > 0;
  echoes.has_means = echoes.has_diffuse = false;
  const double rate = sonar.bandwidth_hz / plan.transform;
  workers.for_each((count + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    auto scratch = pool.take();
    const std::size_t first = chunk * kChunk;
    const int size = static_cast<int>(std::min<std::size_t>(kChunk, count - first));
    gather({list.items.data() + first, static_cast<std::size_t>(size)}, *scratch, echoes);
    kernels.place(rate, plan.grid.spread.points, plan.grid.spread.width, scratch->delay_s, size,
                  echoes.first.data() + first, echoes.offset.data() + first);
    for (int i = 0; echoes.keeps_shift && i < size; ++i) {
      echoes.delay[first + i] = scratch->delay_s[i];
      echoes.doppler[first + i] = list.items[first + i].doppler;
    }
    body(first, size, *scratch);
  });
}

// Calls value(beam, first sample, count, scratch, out) for stretches of all volume cells.
template <class Value>
void for_each_cell(const NodePlan& plan, Pool<EchoScratch>& pool, const Workers& workers,
                   EchoBuffer& echoes, Value&& value) {
  const std::size_t floats = 2 * static_cast<std::size_t>(echoes.draws);
  echoes.cells.need(floats * plan.nodes.beams * plan.samples);
  workers.for_each(plan.nodes.beams, [&](std::size_t beam) {
    auto scratch = pool.take();
    for (int n = 0; n < plan.samples; n += kChunk) {
      const int count = std::min(kChunk, plan.samples - n);
      value(beam, n, count, *scratch, echoes.cells.data() + floats * (beam * plan.samples + n));
    }
  });
}

// Of the cells of a beam from sample n on.
void cell_echoes(const NodePlan& plan, const Kernels& kernels, std::span<const PingTask> tasks,
                 float source_pa_m, std::size_t beam, int n, int count, int draws, EchoScratch& s,
                 float* out) {
  float* rms = s.gain;
  for (int i = 0; i < count; ++i) {
    s.key_low[i] = static_cast<std::uint32_t>(n + i);
    s.key_high[i] = static_cast<std::uint32_t>(beam);
    const double energy = total_energy(tasks[0].volumes, beam * plan.samples + n + i);
    rms[i] = source_pa_m * static_cast<float>(std::sqrt(energy));
  }
  for (std::size_t d = 0; d < tasks.size(); ++d, out += 2) {
    const RandomKeys& keys = tasks[d].keys;
    kernels.draw_normals(keys.volume, keys.speckle_ping, s.key_low, s.key_high, count, s.normal_re,
                         s.normal_im);
    for (int i = 0; i < count; ++i) {
      out[2 * draws * i] = rms[i] * s.normal_re[i];
      out[2 * draws * i + 1] = rms[i] * s.normal_im[i];
    }
  }
}

}  // namespace

bool has_means(const PingTask& task) {
  return std::ranges::any_of(task.scatterers->items,
                             [](const Scatterer& s) { return s.mean != 0.0f; });
}

void series_echoes(const NodePlan& plan, const Kernels& kernels, const Sonar& sonar,
                   std::span<const PingTask> tasks, EchoAmplitude amplitude,
                   Pool<EchoScratch>& pool, const Workers& workers, EchoBuffer& echoes) {
  ENSONIFY_ASSERT(!tasks.empty() && tasks.size() <= kDraws);
  const auto source_pa_m = static_cast<float>(source_pressure_pa_m(sonar));
  const bool drawn = amplitude == EchoAmplitude::drawn;
  const int draws = tasks.size() == 1 ? 1 : kDraws;
  echoes.draws = draws;
  for_each_chunk(plan, kernels, sonar, *tasks[0].scatterers, pool, workers, echoes,
                 [&](std::size_t first, int count, EchoScratch& s) {
                   kernels.turn_paths(sonar.frequency_hz, source_pa_m, s.delay_s, s.gain, count,
                                      &s.path);
                   float* value = echoes.value.data() + 2 * first * draws;
                   for (std::size_t d = 0; d < tasks.size(); ++d, value += 2) {
                     if (!drawn) {
                       kernels.apply_paths(&s.path, s.mean_re, s.mean_im, count, 2 * draws, value);
                       continue;
                     }
                     const RandomKeys& keys = tasks[d].keys;
                     float* re = s.normal_re;
                     float* im = s.normal_im;
                     kernels.draw_normals(keys.speckle, keys.speckle_ping, s.key_low, s.key_high,
                                          count, re, im);
                     for (int i = 0; i < count; ++i) {
                       re[i] = amplitude_part(s.mean_re[i], s.deviation[i], re[i]);
                       im[i] = amplitude_part(s.mean_im[i], s.deviation[i], im[i]);
                     }
                     kernels.apply_paths(&s.path, re, im, count, 2 * draws, value);
                   }
                 });
  echoes.has_cells = drawn && !tasks[0].volumes.empty();
  if (!echoes.has_cells) return;
  for_each_cell(plan, pool, workers, echoes,
                [&](std::size_t beam, int n, int count, EchoScratch& s, float* out) {
                  cell_echoes(plan, kernels, tasks, source_pa_m, beam, n, count, draws, s, out);
                });
}

void power_echoes(const NodePlan& plan, const Kernels& kernels, const Sonar& sonar,
                  const PingTask& task, Pool<EchoScratch>& pool, const Workers& workers,
                  EchoBuffer& echoes) {
  const double source_pa_m = source_pressure_pa_m(sonar);
  echoes.draws = 1;
  for_each_chunk(plan, kernels, sonar, *task.scatterers, pool, workers, echoes,
                 [&](std::size_t first, int count, EchoScratch& s) {
                   float* out = echoes.value.data() + 2 * first;
                   for (int i = 0; i < count; ++i) {
                     const float rms = static_cast<float>(source_pa_m) * s.deviation[i] * s.gain[i];
                     out[2 * i] = out[2 * i + 1] = rms * rms;
                   }
                 });
  echoes.has_cells = !task.volumes.empty();
  if (!echoes.has_cells) return;
  for_each_cell(plan, pool, workers, echoes,
                [&](std::size_t beam, int n, int count, EchoScratch&, float* out) {
                  for (int i = 0; i < count; ++i) {
                    const double energy = total_energy(task.volumes, beam * plan.samples + n + i);
                    out[2 * i] = out[2 * i + 1] =
                        static_cast<float>(source_pa_m * source_pa_m * energy);
                  }
                });
}

}  // namespace ensonify
