#include "synthesis/cuda/ping_batch.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "synthesis/cpu/array_power.h"

namespace ensonify {
namespace {

// Sorts a ping's echoes, which are the batch's echoes from `first` on in the order of the list, by
// delay. Writes the records of Doppler echoes from `next_shift` on.
void order_by_delay(const ScattererList& list, std::uint32_t first, std::uint32_t next_shift,
                    PingBatch& batch) {
  std::vector<SortKey> keys(list.size());
  for (std::uint32_t i = 0; i < keys.size(); ++i) keys[i] = {list.items[i].delay_s, 0, i};
  sort_keys(keys);
  const auto begin = batch.echoes.begin() + first;
  const std::vector<EchoRecord> echoes(begin, begin + static_cast<std::ptrdiff_t>(keys.size()));
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Scatterer& s = list.items[keys[i].index];
    const double cosine = unit_vector(s.arrival.azimuth_rad, s.arrival.elevation_rad).y;
    batch.echoes[first + i] = echoes[keys[i].index];
    batch.arrivals[first + i] = {static_cast<double>(s.received_path_m), cosine};
    if (s.doppler == 0) continue;
    batch.shifts[next_shift++] = {first + static_cast<std::uint32_t>(i), s.doppler};
  }
}

// Sorts echoes [first, last) by group of cells, and keeps their order within a group.
// offset: [groups + 1].
void order_by_direction(const PowerGrid& grid, std::uint32_t first, std::uint32_t last,
                        std::uint32_t groups, PingBatch& batch, std::uint32_t* offset) {
  std::vector<std::uint32_t> cell(last - first), next(groups + 1);
  for (std::uint32_t i = first; i < last; ++i) {
    cell[i - first] = static_cast<std::uint32_t>(grid.cell_of(batch.arrivals[i].cosine));
    ++next[cell[i - first] / kCellsPerNode + 1];
  }
  next[0] = first;
  for (std::uint32_t g = 0; g < groups; ++g) next[g + 1] += next[g];
  std::copy(next.begin(), next.end(), offset);
  for (std::uint32_t i = first; i < last; ++i) {
    const std::uint32_t c = cell[i - first];
    batch.directed[next[c / kCellsPerNode]++] = {i, c};
  }
}

struct ListSummary {
  bool has_means = false;
  std::uint32_t shifted = 0;
};

// Writes the echoes of one ping to the batch from `first` on.
ListSummary fill_echoes(const ScattererList& list, std::uint32_t ping, std::uint32_t first,
                        PingBatch& batch) {
  ListSummary summary;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Scatterer& s = list.items[i];
    summary.has_means |= s.mean != std::complex<float>(0);
    summary.shifted += s.doppler != 0 ? 1 : 0;
    batch.echoes[first + i] = {s.delay_s, s.key, s.mean.real(), s.mean.imag(), s.standard_deviation,
                               s.gain};
    batch.ping_of[first + i] = ping;
  }
  return summary;
}

// Writes the Doppler records of one ping to the batch from `next` on.
void fill_shifts(const ScattererList& list, std::uint32_t first, std::uint32_t next,
                 std::uint32_t* offset, PingBatch& batch) {
  for (std::size_t j = 0; j + 1 < list.beam_offset.size(); ++j) {
    offset[j] = next;
    for (std::uint32_t i = list.beam_offset[j]; i < list.beam_offset[j + 1]; ++i) {
      if (list.items[i].doppler != 0) batch.shifts[next++] = {first + i, list.items[i].doppler};
    }
  }
  offset[list.beam_offset.size() - 1] = next;
}

// Writes the Doppler records of all pings. first: [pings + 1], index of each ping's first echo.
void fill_all_shifts(std::span<const PingTask> tasks, const std::vector<ListSummary>& summary,
                     const std::vector<std::uint32_t>& first, const Workers& workers,
                     PingBatch& batch) {
  std::vector<std::uint32_t> first_shift(tasks.size() + 1);
  for (std::size_t p = 0; p < tasks.size(); ++p) {
    first_shift[p + 1] = first_shift[p] + summary[p].shifted;
  }
  batch.shifts.resize(first_shift.back());
  batch.shift_offset.resize(batch.shifts.empty() ? 0 : batch.offset.size());
  if (batch.shifts.empty()) return;
  workers.for_each(tasks.size(), [&](std::size_t p) {
    fill_shifts(*tasks[p].scatterers, first[p], first_shift[p],
                batch.shift_offset.data() + batch.pings[p].first_offset, batch);
  });
}

void fill_energy(const PingTask& task, std::size_t cells, float* energy) {
  std::fill_n(energy, cells, 0.0f);
  for (std::size_t cell = 0; !task.volumes.empty() && cell < cells; ++cell) {
    energy[cell] = static_cast<float>(total_energy(task.volumes, cell));
  }
}

}  // namespace

void fill_arrivals(const SynthesisSetup& setup, std::span<const PingTask> tasks,
                   const Workers& workers, PingBatch& batch) {
  const PowerGrid grid = make_power_grid(setup);
  const std::uint32_t sectors = setup.sonar.beam_count;
  const std::uint32_t groups = grid.nodes - kPatternTaps + 1;
  batch.arrivals.resize(batch.echoes.size());
  batch.directed.resize(batch.wants_clean ? batch.echoes.size() : 0);
  batch.direction_offset.resize(batch.wants_clean ? tasks.size() * (groups + 1) : 0);
  workers.for_each(tasks.size(), [&](std::size_t p) {
    const std::uint32_t first = batch.pings[p].first_offset;
    const std::uint32_t* offset = batch.offset.data() + first;
    order_by_delay(*tasks[p].scatterers, offset[0],
                   batch.shift_offset.empty() ? 0 : batch.shift_offset[first], batch);
    if (!batch.wants_clean) return;
    order_by_direction(grid, offset[0], offset[sectors], groups, batch,
                       batch.direction_offset.data() + p * (groups + 1));
  });
}

// Includes the temporary memory for sorting.
std::uint64_t array_echo_bytes() {
  return sizeof(ArrivalRecord) + sizeof(DirectionRecord) + sizeof(EchoRecord) + sizeof(SortKey) +
         sizeof(std::uint32_t);
}

PingBatch::PingBatch(std::pmr::memory_resource* memory)
    : echoes(memory),
      ping_of(memory),
      offset(memory),
      shifts(memory),
      shift_offset(memory),
      pings(memory),
      volume_key(memory),
      energy(memory),
      arrivals(memory),
      directed(memory),
      direction_offset(memory) {}

void fill_keys(const SynthesisSetup& setup, std::span<const PingTask> tasks, PingBatch& batch) {
  const std::size_t sectors = setup.sonar.beam_count;
  batch.pings.resize(tasks.size());
  batch.volume_key.resize(tasks.size());
  batch.has_noise = false;
  for (std::size_t p = 0; p < tasks.size(); ++p) {
    const RandomKeys& keys = tasks[p].keys;
    const double noise_power_pa2 = tasks[p].noise_power_pa2;
    batch.pings[p] = {keys.speckle,
                      keys.noise,
                      keys.speckle_ping,
                      keys.noise_ping,
                      static_cast<float>(std::sqrt(noise_power_pa2)),
                      static_cast<std::uint32_t>(p * (sectors + 1))};
    batch.volume_key[p] = keys.volume;
    batch.has_noise |= noise_power_pa2 > 0;
  }
}

void fill_batch(const SynthesisSetup& setup, std::span<const PingTask> tasks,
                const Workers& workers, PingBatch& batch) {
  const std::size_t sectors = setup.sonar.beam_count, count = tasks.size();
  const std::size_t cells = sectors * setup.record.samples;
  std::vector<std::uint32_t> first(count + 1);
  bool has_volumes = false;
  fill_keys(setup, tasks, batch);
  batch.wants_clean = batch.wants_channels = false;
  for (std::size_t p = 0; p < count; ++p) {
    const PingTask& task = tasks[p];
    first[p + 1] = first[p] + static_cast<std::uint32_t>(task.scatterers->size());
    batch.wants_clean |= task.wants_clean;
    batch.wants_channels |= task.wants_channels;
    has_volumes |= !task.volumes.empty();
  }
  batch.echoes.resize(first.back());
  batch.ping_of.resize(first.back());
  batch.offset.resize(count * (sectors + 1));
  batch.energy.resize(has_volumes ? count * cells : 0);
  std::vector<ListSummary> summary(count);
  workers.for_each(count, [&](std::size_t p) {
    const ScattererList& list = *tasks[p].scatterers;
    ENSONIFY_ASSERT(list.beam_offset.size() == sectors + 1);
    summary[p] = fill_echoes(list, static_cast<std::uint32_t>(p), first[p], batch);
    for (std::size_t j = 0; j <= sectors; ++j) {
      batch.offset[p * (sectors + 1) + j] = first[p] + list.beam_offset[j];
    }
    if (has_volumes) fill_energy(tasks[p], cells, batch.energy.data() + p * cells);
  });
  batch.has_means =
      std::any_of(summary.begin(), summary.end(), [](const ListSummary& s) { return s.has_means; });
  fill_all_shifts(tasks, summary, first, workers, batch);
  if (setup.sonar.array) fill_arrivals(setup, tasks, workers, batch);
}

}  // namespace ensonify
