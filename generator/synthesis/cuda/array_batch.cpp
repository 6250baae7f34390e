#include "synthesis/cuda/array_batch.h"

#include <algorithm>

#include "synthesis/cpu/array_patterns.h"

namespace ensonify {
namespace {

// The batch's echoes from `first` on, and of those that are shifted the records from `next_shift`
// on, in the list's order so far.
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

// offset: [groups + 1], of the echoes [first, last). Those of one group stay in their order.
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

// With what their ordering takes for a while.
std::uint64_t array_echo_bytes() {
  return sizeof(ArrivalRecord) + sizeof(DirectionRecord) + sizeof(EchoRecord) + sizeof(SortKey) +
         sizeof(std::uint32_t);
}

}  // namespace ensonify
