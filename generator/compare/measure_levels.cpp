// Levels by range, azimuth, beam, sample and grazing angle; the numbers of levels.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "compare/measure_parts.h"
#include "core/units.h"

namespace ensonify {
namespace {

void grow(Sums::Row& row, std::size_t size) {
  if (row.size() < size) row.resize(size, 0);
}

void add_to(Sums::Row& sum, Sums::Row& count, int bin, double value) {
  if (bin < 0) return;
  sum[static_cast<std::size_t>(bin)] += value;
  count[static_cast<std::size_t>(bin)] += 1;
}

int grazing_bin(double height_m, double range_m) {
  if (!(height_m > 0) || !(range_m > height_m)) return -1;
  constexpr double kStep = kPi / 2 / kGrazingBins;
  return std::min(kGrazingBins - 1, static_cast<int>(std::asin(height_m / range_m) / kStep));
}

void make_room(const Frame& frame, Sums& sums) {
  for (Sums::Row* row : {&sums.range_level, &sums.range_count}) grow(*row, kLevelRangeBins);
  for (Sums::Row* row : {&sums.azimuth_level, &sums.azimuth_count}) grow(*row, kLevelAzimuthBins);
  for (Sums::Row* row : {&sums.grazing_level, &sums.grazing_count}) grow(*row, kGrazingBins);
  for (Sums::Row* row : {&sums.beam_level, &sums.beam_count}) {
    grow(*row, static_cast<std::size_t>(frame.columns));
  }
  for (Sums::Row* row : {&sums.row_level, &sums.row_count}) {
    grow(*row, static_cast<std::size_t>(frame.rows));
  }
  for (Sums::Row* row : {&sums.levels, &sums.far_levels}) grow(*row, kLevelSteps);
}

// Beams and samples are those of crops too, whose columns and rows have no common meaning: only
// grids have a table of them.
void add_pixel(const Frame& frame, int r, int c, double level, int grazing, Sums& sums) {
  const auto step = static_cast<std::size_t>(
      std::clamp(static_cast<int>((level - kLowestLevel) / kLevelStep), 0, kLevelSteps - 1));
  sums.levels[step] += 1;
  if (frame.settings.crops) return;
  const auto row = static_cast<std::size_t>(r), column = static_cast<std::size_t>(c);
  if (frame.is_far[row] != 0) sums.far_levels[step] += 1;
  add_to(sums.range_level, sums.range_count, frame.range_bin[row], level);
  add_to(sums.azimuth_level, sums.azimuth_count, frame.azimuth_bin[column], level);
  if (frame.ground[frame.at(r, c)] == 0) return;
  add_to(sums.grazing_level, sums.grazing_count, grazing, level);
  if (frame.is_whole[row] == 0) return;
  add_to(sums.beam_level, sums.beam_count, c, level);
  add_to(sums.row_level, sums.row_count, r, level);
}

// How many different values there are, none of them below 0: by a table of hashes, in a third of the
// time that sorting takes.
std::size_t distinct_of(const std::vector<float>& amplitudes) {
  constexpr std::uint32_t kEmpty = 0xffffffff;  // the bits of no amplitude
  const int bits = std::bit_width(2 * amplitudes.size() + 1);
  std::vector<std::uint32_t> table(std::size_t{1} << bits, kEmpty);
  std::size_t distinct = 0;
  for (const float amplitude : amplitudes) {
    const auto value = std::bit_cast<std::uint32_t>(amplitude);
    auto at = static_cast<std::size_t>((value * std::uint64_t{0x9e3779b97f4a7c15}) >> (64 - bits));
    while (table[at] != kEmpty && table[at] != value) at = (at + 1) & (table.size() - 1);
    if (table[at] == value) continue;
    table[at] = value;
    ++distinct;
  }
  return distinct;
}

}  // namespace

void add_levels(const Frame& frame, const Picture& picture, double height_m, Sums& sums) {
  make_room(frame, sums);
  std::vector<float> amplitudes;
  amplitudes.reserve(picture.intensity.size());
  for (int r = 0; r < frame.rows; ++r) {
    const int grazing = frame.range_m.empty()
                            ? -1
                            : grazing_bin(height_m, frame.range_m[static_cast<std::size_t>(r)]);
    for (int c = 0; c < frame.columns; ++c) {
      const std::size_t i = frame.at(r, c);
      if (frame.measured[i] == 0) continue;
      const float amplitude = picture.image.amplitude[i];
      amplitudes.push_back(amplitude);
      sums.pixels += 1;
      if (amplitude == frame.top && amplitude > 0) sums.top += 1;
      if (amplitude > 0) {
        add_pixel(frame, r, c, static_cast<double>(picture.level[i]), grazing, sums);
      } else {
        sums.empty += 1;
        if (!frame.settings.crops && frame.is_far[static_cast<std::size_t>(r)] != 0) {
          sums.far_empty += 1;
        }
      }
    }
  }
  sums.distinct += static_cast<double>(distinct_of(amplitudes));
}

}  // namespace ensonify
