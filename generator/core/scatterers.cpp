#include "core/scatterers.h"

#include <algorithm>
#include <tuple>

#include "core/error.h"

namespace ensonify {
namespace {

// From this number of keys on, one bucket per key is faster than comparing keys.
constexpr std::size_t kFewKeys = 16;

bool before(const SortKey& a, const SortKey& b) {
  return std::tie(a.delay_s, a.key, a.index) < std::tie(b.delay_s, b.key, b.index);
}

bool before_in_sector(const Scatterer& a, const Scatterer& b) {
  return std::tie(a.delay_s, a.key) < std::tie(b.delay_s, b.key);
}

// Converts counts to positions: offset[j] becomes the sum of all counts before j.
void add_up(std::vector<std::uint32_t>& offset) {
  for (std::size_t j = 1; j < offset.size(); ++j) offset[j] += offset[j - 1];
}

}  // namespace

void sort_keys(std::vector<SortKey>& keys) {
  const auto [first, last] =
      std::minmax_element(keys.begin(), keys.end(),
                          [](const SortKey& a, const SortKey& b) { return a.delay_s < b.delay_s; });
  if (keys.size() < kFewKeys) return std::sort(keys.begin(), keys.end(), before);
  const double span_s = last->delay_s - first->delay_s;
  // All delays are equal, or the span cannot be divided.
  if (!(span_s > 1e-300 && span_s < 1e300)) return std::sort(keys.begin(), keys.end(), before);
  // One bucket of equal width per key, then each bucket is sorted. If the delays crowd into a few
  // buckets, sorting these takes no longer than sorting all.
  const double earliest = first->delay_s;
  const double per_second = static_cast<double>(keys.size() - 1) / span_s;
  const auto bucket = [&](const SortKey& k) {
    return static_cast<std::size_t>((k.delay_s - earliest) * per_second);
  };
  std::vector<std::uint32_t> end(keys.size() + 1, 0);
  for (const SortKey& k : keys) ++end[bucket(k)];
  add_up(end);
  std::vector<SortKey> sorted(keys.size());
  std::vector<std::uint32_t> begin = end;
  for (std::size_t i = keys.size(); i-- > 0;) sorted[--begin[bucket(keys[i])]] = keys[i];
  for (std::size_t j = 0; j + 1 < end.size(); ++j) {
    if (end[j] - begin[j] < 2) continue;
    std::sort(sorted.begin() + begin[j], sorted.begin() + end[j], before);
  }
  keys = std::move(sorted);
}

ScattererList sorted_by_beam_and_delay(std::span<const Scatterer> scatterers, int beams,
                                       const Workers& workers) {
  ScattererList list;
  list.beam_offset.assign(beams + 1, 0);
  for (const Scatterer& s : scatterers) {
    ENSONIFY_ASSERT(s.beam < static_cast<std::uint32_t>(beams));
    ++list.beam_offset[s.beam + 1];
  }
  add_up(list.beam_offset);
  std::vector<std::uint32_t> next(list.beam_offset.begin(), list.beam_offset.end() - 1);
  std::vector<std::uint32_t> by_beam(scatterers.size());
  for (std::size_t i = 0; i < scatterers.size(); ++i) {
    by_beam[next[scatterers[i].beam]++] = static_cast<std::uint32_t>(i);
  }
  list.items.resize(scatterers.size());
  workers.for_each(beams, [&](std::size_t beam) {
    const std::uint32_t begin = list.beam_offset[beam], end = list.beam_offset[beam + 1];
    std::vector<SortKey> keys;
    keys.reserve(end - begin);
    for (std::uint32_t i = begin; i < end; ++i) {
      const Scatterer& s = scatterers[by_beam[i]];
      keys.push_back({s.delay_s, s.key, by_beam[i]});
    }
    sort_keys(keys);
    for (std::uint32_t i = begin; i < end; ++i) list.items[i] = scatterers[keys[i - begin].index];
  });
  return list;
}

ScattererList sorted_by_beam_and_delay(std::vector<Scatterer> scatterers, int beams) {
  return sorted_by_beam_and_delay(scatterers, beams, Workers(1));
}

void append(std::span<std::vector<Scatterer>> parts, std::vector<Scatterer>& all) {
  std::size_t count = 0;
  for (const auto& part : parts) count += part.size();
  // Repeated growth must stay geometric, so only the first call reserves.
  if (all.empty()) all.reserve(count);
  for (auto& part : parts) {
    all.insert(all.end(), part.begin(), part.end());
    part = {};
  }
}

ScattererList with_more(ScattererList list, std::span<const Scatterer> more,
                        const Workers& workers) {
  if (more.empty()) return list;
  const int beams = static_cast<int>(list.beam_offset.size()) - 1;
  const ScattererList other = sorted_by_beam_and_delay(more, beams, workers);
  ScattererList both;
  both.beam_offset.resize(list.beam_offset.size());
  for (int j = 0; j <= beams; ++j) both.beam_offset[j] = list.beam_offset[j] + other.beam_offset[j];
  both.items.resize(list.size() + other.size());
  workers.for_each(beams, [&](std::size_t beam) {
    const auto at = [&](const ScattererList& l, std::size_t j) {
      return l.items.begin() + l.beam_offset[j];
    };
    std::merge(at(list, beam), at(list, beam + 1), at(other, beam), at(other, beam + 1),
               both.items.begin() + both.beam_offset[beam], before_in_sector);
  });
  return both;
}

}  // namespace ensonify
