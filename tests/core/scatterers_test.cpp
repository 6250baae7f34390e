#include "core/scatterers.h"

#include <algorithm>

#include "catch.h"

using namespace ensonify;

namespace {

Scatterer at(std::uint32_t beam, double delay_s, std::uint64_t key) {
  Scatterer s;
  s.beam = beam;
  s.delay_s = delay_s;
  s.key = key;
  return s;
}

}  // namespace

// Protects the seam's order: beam, then delay, then key, and offsets that agree with it, also for
// sectors that hear nothing.
TEST_CASE("scatterers are sorted by beam, delay and key") {
  std::vector<Scatterer> items{at(3, 2, 1), at(0, 5, 9), at(3, 1, 7), at(0, 5, 2), at(3, 1, 6)};
  const ScattererList list = sorted_by_beam_and_delay(items, 5);
  CHECK(list.beam_offset == std::vector<std::uint32_t>{0, 2, 2, 2, 5, 5});
  std::vector<std::uint64_t> keys;
  for (const Scatterer& s : list.items) keys.push_back(s.key);
  CHECK(keys == std::vector<std::uint64_t>{2, 9, 6, 7, 1});
  std::reverse(items.begin(), items.end());
  const ScattererList again = sorted_by_beam_and_delay(items, 5);
  for (std::size_t i = 0; i < 5; ++i) CHECK(again.items[i].key == list.items[i].key);
}
