#include "core/scatterers.h"

#include <algorithm>
#include <tuple>

#include "catch.h"
#include "core/random.h"

using namespace ensonify;

namespace {

Scatterer at(std::uint32_t beam, double delay_s, std::uint64_t key) {
  Scatterer s;
  s.beam = beam;
  s.delay_s = delay_s;
  s.key = key;
  return s;
}

auto rank(const Scatterer& s) { return std::tuple(s.beam, s.delay_s, s.key); }

// Scatterers of `beams` sectors in no order, with keys of their own. `kind` says how delays lie:
// spread, in few steps, all the same, crowded before one that is far off, rising.
std::vector<Scatterer> random_scatterers(std::size_t count, int beams, int kind) {
  std::vector<Scatterer> list;
  for (std::uint64_t i = 0; i < count; ++i) {
    const double u = uniform(5, 0, i, 0);
    const double delay = kind == 0   ? u
                         : kind == 1 ? static_cast<int>(6 * u)
                         : kind == 2 ? 0.03
                         : kind == 3 ? (i == count / 2 ? 1e9 : 1e-9 * u)
                                     : 1e-3 * static_cast<double>(i);
    const std::uint64_t key = (i * 0x9E3779B97F4A7C15ull) ^ (i << 63);
    Scatterer s = at(static_cast<std::uint32_t>(uniform(5, 0, i, 1) * beams), delay, key);
    s.instance = static_cast<std::uint32_t>(i);
    list.push_back(s);
  }
  return list;
}

// In order, offsets right, and every scatterer there with what belongs to it.
void check_list(const ScattererList& list, std::vector<Scatterer> expected, int beams) {
  std::stable_sort(expected.begin(), expected.end(),
                   [](const Scatterer& a, const Scatterer& b) { return rank(a) < rank(b); });
  REQUIRE(list.size() == expected.size());
  REQUIRE(list.beam_offset.size() == static_cast<std::size_t>(beams) + 1);
  CHECK(list.beam_offset.front() == 0);
  CHECK(list.beam_offset.back() == list.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    REQUIRE(rank(list.items[i]) == rank(expected[i]));
    REQUIRE(list.items[i].instance == expected[i].instance);
    REQUIRE(list.beam_offset[expected[i].beam] <= i);
    REQUIRE(list.beam_offset[expected[i].beam + 1] > i);
  }
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

// Protects the order, whatever the delays are like: the same as a plain sort of them all gives.
TEST_CASE("any scatterers are sorted like by a plain sort") {
  const int kind = GENERATE(0, 1, 2, 3, 4);
  const int beams = GENERATE(1, 3, 40);
  for (const std::size_t count : {0, 1, 2, 15, 16, 17, 300, 2000}) {
    const std::vector<Scatterer> all = random_scatterers(count, beams, kind);
    check_list(sorted_by_beam_and_delay(all, beams), all, beams);
    check_list(sorted_by_beam_and_delay(all, beams, Workers(3)), all, beams);
  }
}

// Protects echoes that come beside those of the rays.
TEST_CASE("more scatterers are put where they belong") {
  const int kind = GENERATE(0, 1, 2);
  const std::vector<Scatterer> all = random_scatterers(900, 20, kind);
  for (const std::size_t first : {0, 1, 450, 899, 900}) {
    const std::vector<Scatterer> some(all.begin(), all.begin() + static_cast<int>(first));
    const std::vector<Scatterer> rest(all.begin() + static_cast<int>(first), all.end());
    check_list(with_more(sorted_by_beam_and_delay(some, 20), rest, Workers(2)), all, 20);
  }
}
