#include "labels/cartesian_display.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include "core/compile_targets.h"
#include "core/error.h"
#include "labels/transpose.h"

namespace ensonify {
namespace {

constexpr float kUnit = 1.0f / (1 << kPlaceBits);
constexpr float kLeast = std::numeric_limits<float>::min(), kMost = 1e37f;

float bounded(double value) {
  return static_cast<float>(std::clamp(value, double{kLeast}, double{kMost}));
}

// In units of 2^15, so that its products with weights along samples stay below the largest float.
float power_of(float level_db) {
  return level_db > kNoEnergyDb ? bounded(std::pow(10.0, double{level_db} / 10)) * kUnit : 0;
}

// Levels of finished data sets are half floats. Few half floats lie between 1 and 256 dB, so their
// intensities are in a table.
class Intensities {
 public:
  Intensities() {
    for (std::uint32_t key = 0; key < kCount; ++key) {
      powers_[key] = power_of(std::bit_cast<float>((key << kUnused) + kFirst));
    }
  }

  // Tables are read by plain loads, which are faster than gathering instructions.
  void find(const float* level_db, std::size_t count, float* intensity) const {
    std::array<std::uint32_t, kMost> keys;
    if (find_keys(level_db, count, keys.data())) {
      for (std::size_t i = 0; i < count; ++i) intensity[i] = powers_[keys[i]];
    } else {
      std::transform(level_db, level_db + count, intensity, power_of);
    }
  }
  static constexpr std::size_t kMost = 64;  // levels at once

 private:
  static constexpr int kUnused = 13;                                       // bits of a half
  static constexpr std::uint32_t kFirst = 0x3f800000u, kCount = 8u << 10;  // of 1 dB

  // False if a level is not in the table.
  ENSONIFY_VECTOR_CLONES static bool find_keys(const float* __restrict level_db, std::size_t count,
                                               std::uint32_t* __restrict keys) {
    std::uint32_t unlisted = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t number = std::bit_cast<std::uint32_t>(level_db[i]) - kFirst;
      const bool silent = level_db[i] <= kNoEnergyDb;
      const bool listed =
          silent | ((number < (kCount << kUnused)) & ((number & ((1u << kUnused) - 1)) == 0));
      unlisted |= !listed;
      keys[i] = silent ? kCount : number >> kUnused;
    }
    return unlisted == 0;
  }

  std::array<float, kCount + 1> powers_{};  // the last is 0
};

// Intensities as Footprints finds them: beam by beam, since samples of a footprint are neighbors.
class Lines {
 public:
  Lines(const Footprints& f, std::span<const float> level_db)
      : values_(std::make_unique_for_overwrite<float[]>(f.line * (f.beams + std::size_t{1}))) {
    const auto beams = static_cast<std::size_t>(f.beams),
               samples = static_cast<std::size_t>(f.samples);
    for (std::size_t n = 0; n < samples; n += kSamples) {
      for (std::size_t beam = 0; beam < beams; beam += kBeams) {
        put(level_db.data() + n * beams + beam, beams, std::min(kSamples, samples - n),
            std::min(kBeams, beams - beam), values_.get() + beam * f.line + n, f.line);
      }
    }
    // What has no weight is read, too.
    for (std::size_t beam = 0; beam <= beams; ++beam) {
      float* line = values_.get() + beam * f.line;
      std::fill(line + (beam < beams ? samples : 0), line + f.line, 0.0f);
    }
  }
  const float* data() const { return values_.get(); }

 private:
  static constexpr std::size_t kSamples = 16, kBeams = Intensities::kMost;  // whole cache lines

  static void put(const float* level_db, std::size_t stride, std::size_t samples, std::size_t beams,
                  float* to, std::size_t line) {
    static const Intensities table;
    float block[kSamples][kBeams];
    for (std::size_t n = 0; n < samples; ++n) table.find(level_db + n * stride, beams, block[n]);
    transpose(block[0], kBeams, samples, beams, to, line);
  }

  std::unique_ptr<float[]> values_;
};

inline float sum_of(Four four) { return (four[0] + four[1]) + (four[2] + four[3]); }

// Means of footprints that are at most one beam wide. `kTaps`: Footprints::taps; 0: any.
template <int kTaps>
void narrow_means(const Footprints& f, const float* lines, std::size_t start, std::size_t count,
                  float* shown) {
  const int taps = kTaps > 0 ? kTaps : f.taps;
  const std::uint32_t* from = f.from.data() + start;
  const std::uint16_t* weight = f.sample_weight.data() + start * static_cast<std::size_t>(taps);
  const std::uint16_t* fraction = f.beam_fraction.data() + start;
  const auto sum = [&](std::size_t i, float along) {
    const float* line = lines + from[i];
    const float* next = line + f.line;
    const std::uint16_t* own = weight + i * static_cast<std::size_t>(taps);
    Four four = {};
    for (int t = 0; t < taps; t += 4) {
      four += four_at(own + t) * ((1 - along) * four_at(line + t) + along * four_at(next + t));
    }
    return four;
  };
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    const Four along = four_at(fraction + i) * kUnit;
    Four four[4] = {sum(i, along[0]), sum(i + 1, along[1]), sum(i + 2, along[2]),
                    sum(i + 3, along[3])};
    transpose(four);  // four[k] now holds the k-th partial sums
    const Four means = ((four[0] + four[1]) + (four[2] + four[3])) * f.scale;
    std::memcpy(shown + i, &means, sizeof means);
  }
  for (; i < count; ++i) {
    shown[i] = sum_of(sum(i, static_cast<float>(fraction[i]) * kUnit)) * f.scale;
  }
}

// The mean of footprint i of the wide ones.
float wide_mean(const Footprints& f, const float* lines, std::size_t i) {
  const float* line = lines + f.from[f.beam_fraction.size() + i];
  const float* weight = f.wide_weight.data() + i * static_cast<std::size_t>(f.taps);
  const float* begin = f.beam_weight.data() + f.beam_begin[i];
  const float* end = f.beam_weight.data() + f.beam_begin[i + 1];
  Four sum = {};
  for (int t = 0; t < f.taps; t += 4) {
    Four level = {};
    const float* at = line + t;
    for (const float* across = begin; across != end; ++across, at += f.line) {
      level += *across * four_at(at);
    }
    sum += four_at(weight + t) * level;
  }
  return sum_of(sum) * f.scale;
}

void add_means(const Footprints& f, const float* lines, std::size_t start, std::size_t count,
               float* shown) {
  const std::size_t narrow = f.beam_fraction.size();
  const std::size_t plain = start < narrow ? std::min(count, narrow - start) : 0;
  if (f.taps == 4) {
    narrow_means<4>(f, lines, start, plain, shown);
  } else {
    narrow_means<0>(f, lines, start, plain, shown);
  }
  for (std::size_t i = plain; i < count; ++i) shown[i] = wide_mean(f, lines, start + i - narrow);
}

// The gray level of an intensity: where each level begins, and where a search for it begins.
class GrayScale {
 public:
  // `offset_db`: the gain that is not in the intensities.
  GrayScale(const DisplayTable& table, double offset_db) {
    for (std::size_t k = 0; k < 255; ++k) {
      begins_[k] = bounded(std::pow(10.0, (table.steps_db[k] - offset_db) / 10));
    }
    begins_[255] = std::numeric_limits<float>::infinity();
    first_ = key_of(begins_[0]);
    const std::uint32_t last = key_of(begins_[254]);
    std::int32_t level = 0;
    for (std::uint32_t key = first_; key <= last; ++key) {
      starts_.push_back(level);
      const std::int32_t start = level;
      while (level < 255 && key_of(begins_[static_cast<std::size_t>(level)]) == key) ++level;
      most_steps_ = std::max(most_steps_, level - start);
    }
  }

  void find(const float* intensity, std::size_t count, std::int32_t* gray) const {
    const auto last = static_cast<std::int32_t>(starts_.size()) - 1;
    const std::int32_t* starts = starts_.data();
    for (std::size_t i = 0; i < count; ++i) {
      const std::int32_t key = static_cast<std::int32_t>(key_of(intensity[i]) - first_);
      std::int32_t level = starts[std::clamp(key, 0, last)];
      for (int k = 0; k < most_steps_; ++k) level += intensity[i] >= begins_[level];
      gray[i] = level;
    }
  }

 private:
  static constexpr int kShift = 17;  // 64 entries per octave
  static std::uint32_t key_of(float value) { return std::bit_cast<std::uint32_t>(value) >> kShift; }

  std::array<float, 256> begins_{};
  std::vector<std::int32_t> starts_;  // the level at the first intensity with a key
  std::uint32_t first_ = 0;
  int most_steps_ = 0;
};

}  // namespace

std::vector<float> cartesian_gains(const DisplayTable& table, const Footprints& f) {
  std::vector<float> gains;
  if (table.display.spreading == 0 && table.alpha_db_m == 0) return gains;
  gains.reserve(f.to.size());
  for (const std::int32_t to : f.to) {
    const double sample = sample_place(f, to) * kUnit;
    const double range_m = std::max(f.first_sample + sample, 1.0) * table.step_m;
    const double tvg_db =
        table.display.spreading * std::log10(range_m) + 2 * table.alpha_db_m * range_m;
    gains.push_back(bounded(std::pow(10.0, (tvg_db - table.tvg_db.back()) / 10)));
  }
  return gains;
}

GreyImage displayed_cartesian(const DisplayTable& table, const Footprints& f,
                              std::span<const float> gains, double further_gain_db,
                              std::span<const float> level_db) {
  ENSONIFY_ASSERT(level_db.size() == std::size_t(f.beams) * f.samples);
  ENSONIFY_ASSERT(gains.empty() || gains.size() == f.to.size());
  const int rows = f.grid.height_px, columns = f.grid.width_px;
  GreyImage image{rows, columns, std::vector<std::uint8_t>(std::size_t(rows) * columns)};
  const Lines lines(f, level_db);
  const GrayScale scale(table, further_gain_db + table.tvg_db.back());
  constexpr std::size_t kBlock = 2048;
  std::array<float, kBlock> shown;
  std::array<std::int32_t, kBlock> gray;
  for (std::size_t start = 0; start < f.to.size(); start += kBlock) {
    const std::size_t count = std::min(kBlock, f.to.size() - start);
    add_means(f, lines.data(), start, count, shown.data());
    for (std::size_t i = 0; !gains.empty() && i < count; ++i) shown[i] *= gains[start + i];
    scale.find(shown.data(), count, gray.data());
    for (std::size_t i = 0; i < count; ++i) {
      image.pixels[f.to[start + i]] = static_cast<std::uint8_t>(gray[i]);
    }
  }
  return image;
}

}  // namespace ensonify
