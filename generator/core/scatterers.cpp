#include "core/scatterers.h"

#include <algorithm>
#include <tuple>

#include "core/error.h"

namespace ensonify {

ScattererList sorted_by_beam_and_delay(std::vector<Scatterer> scatterers, int beams) {
  std::sort(scatterers.begin(), scatterers.end(), [](const Scatterer& a, const Scatterer& b) {
    return std::tie(a.beam, a.delay_s, a.key) < std::tie(b.beam, b.delay_s, b.key);
  });
  ScattererList list;
  list.beam_offset.assign(beams + 1, 0);
  for (const Scatterer& s : scatterers) {
    ENSONIFY_ASSERT(s.beam < static_cast<std::uint32_t>(beams));
    ++list.beam_offset[s.beam + 1];
  }
  for (int j = 0; j < beams; ++j) list.beam_offset[j + 1] += list.beam_offset[j];
  list.items = std::move(scatterers);
  return list;
}

}  // namespace ensonify
