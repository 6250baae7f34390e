// Sums over pixels from which the statistics follow. They add up over pings and blocks, so that a
// statistic without one block is that of all sums less the block's. Private to compare/.
//
//   Sums  for_each_sum  add  subtract
#pragma once

#include <cstddef>
#include <vector>

namespace ensonify {

struct Sums {
  using Row = std::vector<double>;

  double images = 0;
  // Levels in dB of pixels with an echo. By bins of range and azimuth, and of the grazing angle:
  Row range_level, range_count, azimuth_level, azimuth_count, grazing_level, grazing_count;
  // ... of samples that are ground in nearly all beams, by beams and samples of the grid:
  Row beam_level, beam_count, row_level, row_count;
  // Numbers of pixels by level, all and those of the farthest tenth of the ranges.
  Row levels, far_levels;
  double pixels = 0, empty = 0, far_empty = 0, top = 0;
  double distinct = 0;  // different amplitudes of an image
  // Of homogeneous pixels: moments of the normalized intensity x, and of its level in dB.
  double x0 = 0, x1 = 0, x2 = 0;
  double log0 = 0, log1 = 0, log2 = 0, log3 = 0;
  // ... by bins of range.
  Row range_x0, range_x1, range_x2;
  // Sums of (x - 1)(x' - 1) and their numbers, by lags from 0.
  Row range_products, range_pairs, azimuth_products, azimuth_pairs, ping_products, ping_pairs;
  // Bright isolated maxima: their number, and levels in dB under their peaks.
  double maxima = 0;
  Row range_cut, azimuth_cut;
  double before = 0, behind = 0, beside = 0;  // over the background
  // Dark pixels, their levels in dB relative to the surroundings, far edges of dark regions.
  double dark = 0, dark_of = 0, dark_level = 0, edges = 0;
  Row edge_profile;
};

template <class Left, class Right, class Use>
void for_each_sum(Left& a, Right& b, Use use) {
  const auto each = [&](auto member) { use(a.*member, b.*member); };
  for (const auto member :
       {&Sums::images,   &Sums::pixels, &Sums::empty, &Sums::far_empty, &Sums::top,
        &Sums::distinct, &Sums::x0,     &Sums::x1,    &Sums::x2,        &Sums::log0,
        &Sums::log1,     &Sums::log2,   &Sums::log3,  &Sums::maxima,    &Sums::before,
        &Sums::behind,   &Sums::beside, &Sums::dark,  &Sums::dark_of,   &Sums::dark_level,
        &Sums::edges}) {
    each(member);
  }
  for (const auto member :
       {&Sums::range_level,   &Sums::range_count,      &Sums::azimuth_level, &Sums::azimuth_count,
        &Sums::grazing_level, &Sums::grazing_count,    &Sums::beam_level,    &Sums::beam_count,
        &Sums::row_level,     &Sums::row_count,        &Sums::levels,        &Sums::far_levels,
        &Sums::range_x0,      &Sums::range_x1,         &Sums::range_x2,      &Sums::range_products,
        &Sums::range_pairs,   &Sums::azimuth_products, &Sums::azimuth_pairs, &Sums::ping_products,
        &Sums::ping_pairs,    &Sums::range_cut,        &Sums::azimuth_cut,   &Sums::edge_profile}) {
    auto& left = a.*member;
    const auto& right = b.*member;
    if (left.size() < right.size()) left.resize(right.size(), 0);
    for (std::size_t i = 0; i < right.size(); ++i) use(left[i], right[i]);
  }
}

inline void add(Sums& sums, const Sums& more) {
  for_each_sum(sums, more, [](double& a, double b) { a += b; });
}
inline void subtract(Sums& sums, const Sums& part) {
  for_each_sum(sums, part, [](double& a, double b) { a -= b; });
}

}  // namespace ensonify
