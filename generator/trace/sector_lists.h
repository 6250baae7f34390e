// A list of scatterers filled sector by sector, each sorted by itself. Private to trace/.
//
//   SectorWork      what sorting a sector needs
//   for_each_block  sectors in blocks that share one SectorWork
//   close_up        takes out the room that sectors did not need
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "acoustics/scattering.h"
#include "core/parallel.h"
#include "core/scatterers.h"

namespace ensonify {

// Kept from one sector to the next.
struct SectorWork {
  std::vector<SortKey> order;
  std::vector<ScattererMoments> moments;
};

// Calls body(beam, work) for all beams, those of a block one after the other.
template <class Work, class Body>
void for_each_block(std::size_t beams, const Workers& workers, const Body& body) {
  constexpr std::size_t kBlock = 16;
  workers.for_each((beams + kBlock - 1) / kBlock, [&](std::size_t block) {
    Work work;
    const std::size_t end = std::min((block + 1) * kBlock, beams);
    for (std::size_t beam = block * kBlock; beam < end; ++beam) body(beam, work);
  });
}

// The scatterers of beam j are the first count[j] from room[j] on; they move together.
inline void close_up(const std::vector<std::uint32_t>& room,
                     const std::vector<std::uint32_t>& count, ScattererList& list) {
  list.beam_offset.assign(1, 0);
  for (std::size_t j = 0; j < count.size(); ++j) {
    const auto first = list.items.begin() + room[j];
    const std::uint32_t offset = list.beam_offset.back();
    if (offset != room[j]) std::copy(first, first + count[j], list.items.begin() + offset);
    list.beam_offset.push_back(offset + count[j]);
  }
  list.items.resize(list.beam_offset.back());
}

}  // namespace ensonify
