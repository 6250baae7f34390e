#include "report/statistics_pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.h"
#include "report/webp.h"

namespace ensonify {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kMeanSpan_db = 80;  // of mean levels, below the highest

// [samples x beams], NaN for none; codes of what lies beyond `least` and `most` are those of them.
Result<std::string> picture_of(const std::vector<double>& values, const StoredSequence& sequence,
                               double least, double most) {
  const auto width = static_cast<std::size_t>(sequence.beams);
  const auto height = static_cast<std::size_t>(sequence.samples);
  const std::size_t step =
      (std::max(width, height) + kWebpMostPixels - 1) / std::size_t{kWebpMostPixels};
  std::vector<std::uint8_t> grey;
  for (std::size_t row = 0; row < height; row += step) {
    for (std::size_t column = 0; column < width; column += step) {
      grey.push_back(grey_code(values[row * width + column], least, most));
    }
  }
  return lossless_grey(grey, static_cast<int>((width + step - 1) / step),
                       static_cast<int>((height + step - 1) / step));
}

Result<CodedArray> contrast_of(const PictureJob& job, const StoredSequence& sequence,
                               Chunks& chunks) {
  const auto values = read_statistics(job.dataset, sequence, "contrast");
  if (!values) return values.error();
  CodedArray array{"contrast", "", "standard deviation of the intensity over its mean", 0, 2, 0};
  auto picture = picture_of(*values, sequence, array.min, array.max);
  if (!picture) return picture.error();
  array.chunk = chunks.add(std::move(*picture));
  return array;
}

Result<CodedArray> level_of(const PictureJob& job, const StoredSequence& sequence, Chunks& chunks) {
  auto values = read_statistics(job.dataset, sequence, "mean_intensity");
  if (!values) return values.error();
  double highest_db = kNoEnergyDb;
  for (double& value : *values) {
    const double db = level_db(value);
    value = db > kNoEnergyDb ? db : kNan;
    highest_db = std::max(highest_db, db);
  }
  CodedArray array{"mean_intensity",
                   "dB",
                   "level of the mean intensity, dB re 1 uPa",
                   std::ceil(highest_db) - kMeanSpan_db,
                   std::ceil(highest_db),
                   0};
  auto picture = picture_of(*values, sequence, array.min, array.max);
  if (!picture) return picture.error();
  array.chunk = chunks.add(std::move(*picture));
  return array;
}

}  // namespace

Result<std::vector<CodedStatistics>> encode_statistics(const PictureJob& job, Chunks& chunks) {
  std::vector<CodedStatistics> all;
  for (std::size_t i = 0; i < job.survey.sequences.size(); ++i) {
    const ShownSequence& sequence = job.survey.sequences[i];
    if (sequence.facts.realisations == 0) continue;
    CodedStatistics statistics{i, sequence.facts.realisations, {}};
    for (const auto make : {level_of, contrast_of}) {
      auto array = make(job, sequence.stored, chunks);
      if (!array) return array.error();
      statistics.arrays.push_back(std::move(*array));
    }
    all.push_back(std::move(statistics));
  }
  return all;
}

}  // namespace ensonify
