// A list of scatterers made by beam cells, each sorted separately. Private to trace/.
//
//   SectorWork        buffers for one beam cell
//   list_of_sectors
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "acoustics/scattering.h"
#include "core/parallel.h"
#include "core/scatterers.h"

namespace ensonify {

// Buffers that are reused from one beam cell to the next.
struct SectorWork {
  std::vector<SortKey> order;
  std::vector<ScattererMoments> moments;
};

// fill(beam, work, scatterers) appends the scatterers of a beam, at most most[beam], sorted by
// delay and key. A single thread fills the list directly; several threads fill one part each, which
// is copied once.
template <class Work, class Fill>
ScattererList list_of_sectors(std::span<const std::uint32_t> most, const Workers& workers,
                              const Fill& fill) {
  constexpr std::size_t kBlock = 16;
  const std::size_t beams = most.size(), block = workers.threads() == 1 ? beams : kBlock;
  std::vector<std::vector<Scatterer>> parts((beams + block - 1) / block);
  ScattererList list;
  list.beam_offset.assign(beams + 1, 0);
  workers.for_each(parts.size(), [&](std::size_t p) {
    const std::size_t first = p * block, end = std::min(first + block, beams);
    const auto room = most.subspan(first, end - first);
    parts[p].reserve(std::accumulate(room.begin(), room.end(), std::size_t{0}));
    Work work;
    for (std::size_t beam = first; beam < end; ++beam) {
      const std::size_t before = parts[p].size();
      fill(beam, work, parts[p]);
      list.beam_offset[beam + 1] = static_cast<std::uint32_t>(parts[p].size() - before);
    }
  });
  std::partial_sum(list.beam_offset.begin(), list.beam_offset.end(), list.beam_offset.begin());
  if (parts.size() == 1) {
    list.items = std::move(parts.front());
  } else {
    append(parts, list.items);
  }
  return list;
}

}  // namespace ensonify
