#include "synthesis/cpu/echoes.h"

#include <algorithm>
#include <cmath>

namespace ensonify {
namespace {

constexpr int kChunk = EchoScratch::kCount;

void need(EchoBuffer& echoes, std::size_t count) {
  echoes.value.need(2 * count);
  echoes.offset.need(count);
  echoes.first.need(count);
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

// body(first, count, scratch) for every chunk of the list, and the places of its echoes.
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
    kernels.place(rate, plan.spread.points, plan.spread.width, scratch->delay_s, size,
                  echoes.first.data() + first, echoes.offset.data() + first);
    body(first, size, *scratch);
  });
}

// value(beam, first sample, count, scratch, out) for stretches of all cells.
template <class Value>
void for_each_cell(const NodePlan& plan, Pool<EchoScratch>& pool, const Workers& workers,
                   EchoBuffer& echoes, Value&& value) {
  echoes.cells.need(std::size_t(2) * plan.nodes.beams * plan.samples);
  workers.for_each(plan.nodes.beams, [&](std::size_t beam) {
    auto scratch = pool.take();
    for (int n = 0; n < plan.samples; n += kChunk) {
      const int count = std::min(kChunk, plan.samples - n);
      value(beam, n, count, *scratch, echoes.cells.data() + 2 * (beam * plan.samples + n));
    }
  });
}

}  // namespace

void series_echoes(const NodePlan& plan, const Kernels& kernels, const Sonar& sonar,
                   const PingTask& task, EchoAmplitude amplitude, Pool<EchoScratch>& pool,
                   const Workers& workers, EchoBuffer& echoes) {
  const RandomKeys& keys = task.keys;
  const auto source_pa_m = static_cast<float>(source_pressure_pa_m(sonar));
  const bool drawn = amplitude == EchoAmplitude::drawn;
  for_each_chunk(plan, kernels, sonar, *task.scatterers, pool, workers, echoes,
                 [&](std::size_t first, int count, EchoScratch& s) {
                   float* re = s.mean_re;
                   float* im = s.mean_im;
                   if (drawn) {
                     kernels.draw_normals(keys.speckle, keys.speckle_ping, s.key_low, s.key_high,
                                          count, s.normal_re, s.normal_im);
                     for (int i = 0; i < count; ++i) {
                       re[i] += s.deviation[i] * s.normal_re[i];
                       im[i] += s.deviation[i] * s.normal_im[i];
                     }
                   }
                   kernels.apply_path(sonar.frequency_hz, source_pa_m, s.delay_s, s.gain, re, im,
                                      count, echoes.value.data() + 2 * first);
                 });
  echoes.has_cells = drawn && !task.volumes.empty();
  if (!echoes.has_cells) return;
  for_each_cell(plan, pool, workers, echoes,
                [&](std::size_t beam, int n, int count, EchoScratch& s, float* out) {
                  for (int i = 0; i < count; ++i) {
                    s.key_low[i] = static_cast<std::uint32_t>(n + i);
                    s.key_high[i] = static_cast<std::uint32_t>(beam);
                  }
                  kernels.draw_normals(keys.volume, keys.speckle_ping, s.key_low, s.key_high, count,
                                       s.normal_re, s.normal_im);
                  for (int i = 0; i < count; ++i) {
                    const double energy = total_energy(task.volumes, beam * plan.samples + n + i);
                    const float rms = source_pa_m * static_cast<float>(std::sqrt(energy));
                    out[2 * i] = rms * s.normal_re[i];
                    out[2 * i + 1] = rms * s.normal_im[i];
                  }
                });
}

void power_echoes(const NodePlan& plan, const Kernels& kernels, const Sonar& sonar,
                  const PingTask& task, Pool<EchoScratch>& pool, const Workers& workers,
                  EchoBuffer& echoes) {
  const double source_pa_m = source_pressure_pa_m(sonar);
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
