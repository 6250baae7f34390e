// Compares what was measured in two data sets.
//
//   Verdict  ComparedStatistic  Comparison
//   compare_statistics
//   verdict_word
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compare/classifier.h"
#include "compare/measure_blocks.h"

namespace ensonify {

enum class Verdict { agrees, differs, left_out };
const char* verdict_word(Verdict verdict);

// A single value or, with `positions`, a curve or a histogram.
struct ComparedStatistic {
  std::string group, id, title, unit;
  Verdict verdict = Verdict::left_out;
  std::string reason;  // why it was left out
  // Values and their standard errors; of single values one each. NaN: not defined.
  std::vector<double> real, real_error, simulated, simulated_error;
  bool free_constant = false;                               // of a curve
  std::vector<double> real_positions, simulated_positions;  // of a curve
  std::string axis;                                         // of a curve
  bool is_histogram = false;                                // of a curve; compared by a distance
  // A single value: real less simulated, with its 95 % interval. A curve: the weighted rms
  // difference, or the distance of two histograms, and the interval that holds it for 95 % of equal
  // data sets.
  double difference = 0, low = 0, high = 0;
  // Of a curve: the share of permutations of the blocks with as large a difference.
  std::optional<double> share;

  bool is_curve() const { return !axis.empty(); }
};

inline constexpr int kHistogramFrom = -50, kHistogramTo = 50;  // dB

struct Comparison {
  std::size_t real_images = 0, simulated_images = 0, real_blocks = 0, simulated_blocks = 0;
  bool crops = false;
  double gain_db = 0;  // mean level of the real data less that of the simulated
  std::vector<ComparedStatistic> statistics;
  std::optional<ClassifierResult> classifier;  // absent: too few patches
  // Shares of the pixels with an echo by level over the mean level, kHistogramFrom and up in steps
  // of 1 dB.
  std::vector<double> real_histogram, simulated_histogram;
  std::vector<std::string> notes;  // on the data, for the reader
};

// Needs 2 blocks or more in each, and the same settings.
Comparison compare_statistics(const BlockStatistics& real, const BlockStatistics& simulated,
                              std::uint64_t seed, const Workers& workers);

}  // namespace ensonify
