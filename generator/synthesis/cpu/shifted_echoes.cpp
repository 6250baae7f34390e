#include "synthesis/cpu/shifted_echoes.h"

#include <algorithm>
#include <set>

namespace ensonify {
namespace {

constexpr std::size_t kPlaced = 4096;  // echoes that are placed at once

// The nodes that echoes have weights at, in increasing order.
std::set<int> nodes_of_echoes(const DopplerNodes& nodes, std::span<const std::uint32_t> beam_offset,
                              const EchoBuffer& echoes, const Workers& workers) {
  const DopplerWeigher weigher(nodes);
  std::mutex mutex;
  std::set<int> all;
  workers.for_each(beam_offset.size() - 1, [&](std::size_t beam) {
    std::set<int> own;
    double weight[DopplerNodes::kMostDegree + 1];
    DopplerWeigher::Band last{0, 0};
    for (std::size_t i = beam_offset[beam]; i < beam_offset[beam + 1]; ++i) {
      if (echoes.doppler[i] == 0) {
        own.insert(0);
        continue;
      }
      const auto band = weigher.weigh(static_cast<double>(echoes.doppler[i]), weight);
      if (band.first_node == last.first_node && band.step == last.step) continue;
      for (int q = 0; q <= nodes.degree; ++q) own.insert(band.first_node + band.step * q);
      last = band;
    }
    const std::lock_guard lock(mutex);
    all.merge(own);
  });
  return all;
}

// Adds an echo to those of a set in a beam. Echoes between that are not the set's have the value 0.
void put(const EchoBuffer& echoes, std::uint32_t i, double weight, ShiftedSet& set,
         std::size_t beam) {
  if (set.begin[beam] == set.end[beam]) set.begin[beam] = set.end[beam] = i;
  float* value = set.value.data();
  std::fill(value + 2 * std::size_t{set.end[beam]}, value + 2 * std::size_t{i}, 0.0f);
  const auto w = static_cast<float>(weight);
  value[2 * std::size_t{i}] = w * echoes.value[2 * std::size_t{i}];
  value[2 * std::size_t{i} + 1] = w * echoes.value[2 * std::size_t{i} + 1];
  set.end[beam] = i + 1;
}

}  // namespace

const NodeFilter& NodeFilters::at(const NodeSpectra& spectra, int node, double tolerance) {
  const std::lock_guard lock(mutex_);
  const auto [entry, is_new] = made_.try_emplace(node);
  if (is_new) {
    const std::vector<std::complex<double>> spectrum = spectra.at(node);
    entry->second.is_audible = !spectrum.empty();
    if (!spectrum.empty()) entry->second.grid = make_series_filter(spectrum, tolerance);
  }
  return entry->second;
}

bool place_sets(const NodePlan& plan, const Kernels& kernels, const Sonar& sonar, double tolerance,
                const NodeSpectra& spectra, NodeFilters& filters,
                std::span<const std::uint32_t> beam_offset, const EchoBuffer& echoes,
                const Workers& workers, std::vector<ShiftedSet>& sets) {
  std::size_t used = 0;
  for (const int node : nodes_of_echoes(spectra.nodes(), beam_offset, echoes, workers)) {
    const GridFilter* grid = &plan.grid;
    if (node != 0) {
      const NodeFilter& filter = filters.at(spectra, node, tolerance);
      if (!filter.is_audible) continue;
      if (!filter.grid) return false;
      grid = filter.grid.get();
    }
    if (sets.size() == used) sets.emplace_back();
    sets[used].node = node;
    sets[used++].grid = grid;
  }
  sets.resize(used);
  const std::size_t count = beam_offset.back();
  const double rate = sonar.bandwidth_hz / plan.transform;
  for (ShiftedSet& set : sets) {
    set.value.need(2 * count);
    set.offset.need(count);
    set.first.need(count);
    workers.for_each((count + kPlaced - 1) / kPlaced, [&](std::size_t chunk) {
      const std::size_t first = chunk * kPlaced;
      kernels.place(rate, set.grid->spread.points, set.grid->spread.width,
                    echoes.delay.data() + first, static_cast<int>(std::min(kPlaced, count - first)),
                    set.first.data() + first, set.offset.data() + first);
    });
  }
  return true;
}

void weigh_sets(const DopplerNodes& nodes, std::span<const std::uint32_t> beam_offset,
                const EchoBuffer& echoes, const Workers& workers, std::vector<ShiftedSet>& sets) {
  const DopplerWeigher weigher(nodes);
  const std::size_t beams = beam_offset.size() - 1;
  for (ShiftedSet& set : sets) {
    set.begin.assign(beams, 0);
    set.end.assign(beams, 0);
  }
  workers.for_each(beams, [&](std::size_t beam) {
    double weight[DopplerNodes::kMostDegree + 1];
    ShiftedSet* set_of[DopplerNodes::kMostDegree + 1] = {};
    DopplerWeigher::Band last{0, 0};
    for (std::uint32_t i = beam_offset[beam]; i < beam_offset[beam + 1]; ++i) {
      const auto band = weigher.weigh(static_cast<double>(echoes.doppler[i]), weight);
      if (band.first_node != last.first_node || band.step != last.step) {
        last = band;
        for (int q = 0; q <= nodes.degree; ++q) {
          const int node = band.first_node + band.step * q;
          const auto found = std::find_if(sets.begin(), sets.end(),
                                          [&](const ShiftedSet& set) { return set.node == node; });
          set_of[q] = found == sets.end() ? nullptr : &*found;
        }
      }
      for (int q = 0; q <= nodes.degree; ++q) {
        if (weight[q] != 0 && set_of[q]) put(echoes, i, weight[q], *set_of[q], beam);
      }
    }
  });
}

std::vector<EchoSet> echo_sets(std::vector<ShiftedSet>& sets) {
  std::vector<EchoSet> result;
  for (ShiftedSet& set : sets) {
    result.push_back(
        {set.grid, {set.value.data(), set.first.data(), set.offset.data()}, set.begin, set.end});
  }
  return result;
}

}  // namespace ensonify
