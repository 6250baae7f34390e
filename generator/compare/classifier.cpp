#include "compare/classifier.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "compare/jackknife.h"
#include "core/random.h"

namespace ensonify {
namespace {

constexpr std::size_t kFolds = 10, kLeastPatches = 20, kExchanges = 200;
constexpr int kWeights = static_cast<int>(kFeatures) + 1;  // with the constant
constexpr double kRidge = 1e-3;                            // times the number of patches
constexpr int kIterations = 25;

using Features = Eigen::Array<double, static_cast<int>(kFeatures), 1>;
using Weights = Eigen::Matrix<double, kWeights, 1>;
using Matrix = Eigen::Matrix<double, kWeights, kWeights>;
using Blocks = std::vector<std::vector<PatchFeatures>>;

Eigen::Map<const Features> values_of(const PatchFeatures& patch) {
  return Eigen::Map<const Features>(patch.data());
}

// The constant has nearly none.
Weights ridge() {
  Weights ridge = Weights::Constant(kRidge);
  ridge(kWeights - 1) = 1e-9;
  return ridge;
}

struct Scaling {
  Features mean, deviation;

  Weights row(const PatchFeatures& patch) const {
    Weights x;
    x << ((values_of(patch) - mean) / deviation).matrix(), 1;
    return x;
  }
};

// A block's part in the first step of the regression from 0, where p = 1/2 for all.
struct BlockMoments {
  Matrix squares = Matrix::Zero();
  Weights sum = Weights::Zero();
  double patches = 0;
};

struct Training {
  std::vector<Weights> rows;
  std::vector<double> labels, weights;  // weights: both data sets count as much
};

Weights fitted(const Training& training) {
  Weights beta = Weights::Zero();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Matrix hessian = ridge().asDiagonal();
    Weights gradient = -ridge().cwiseProduct(beta);
    for (std::size_t i = 0; i < training.rows.size(); ++i) {
      const Weights& x = training.rows[i];
      const double p = 1 / (1 + std::exp(-beta.dot(x)));
      gradient += training.weights[i] * (training.labels[i] - p) * x;
      hessian += training.weights[i] * std::max(p * (1 - p), 1e-9) * x * x.transpose();
    }
    const Weights step = hessian.ldlt().solve(gradient);
    beta += step;
    if (step.cwiseAbs().maxCoeff() < 1e-8) break;
  }
  return beta;
}

std::vector<BlockMoments> moments_of(const Blocks& blocks, const Scaling& scaling) {
  std::vector<BlockMoments> all(blocks.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (const PatchFeatures& patch : blocks[b]) {
      const Weights x = scaling.row(patch);
      all[b].patches += 1;
      all[b].sum += x;
      all[b].squares += x * x.transpose();
    }
  }
  return all;
}

// The first step for all blocks but those of a fold. `order` are the blocks, those of the first
// data set first.
Weights first_step(const std::vector<BlockMoments>& moments, const std::vector<std::size_t>& order,
                   std::size_t first, std::size_t fold, std::size_t folds) {
  std::array<double, 2> patches{};
  const auto is_used = [&](std::size_t i) { return (i < first ? i : i - first) % folds != fold; };
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (is_used(i)) patches[i < first ? 0 : 1] += moments[order[i]].patches;
  }
  Matrix hessian = ridge().asDiagonal();
  Weights gradient = Weights::Zero();
  for (std::size_t i = 0; i < order.size(); ++i) {
    const BlockMoments& block = moments[order[i]];
    if (!is_used(i) || block.patches == 0) continue;
    const double weight = 0.5 / patches[i < first ? 0 : 1];
    gradient += (i < first ? 0.5 : -0.5) * weight * block.sum;
    hessian += 0.25 * weight * block.squares;
  }
  return hessian.ldlt().solve(gradient);
}

Scaling scaling_of(const Blocks& a, const Blocks& b) {
  Features sum = Features::Zero(), squares = Features::Zero();
  double count = 0;
  for (const Blocks* blocks : {&a, &b}) {
    for (const auto& block : *blocks) {
      count += static_cast<double>(block.size());
      for (const PatchFeatures& patch : block) {
        sum += values_of(patch);
        squares += values_of(patch).square();
      }
    }
  }
  const Features mean = sum / count, variance = squares / count - mean.square();
  return {mean, (variance > 1e-20).select(variance.sqrt(), 1.0)};
}

void add_training(const Blocks& blocks, std::size_t fold, std::size_t folds, double label,
                  const Scaling& scaling, Training& training) {
  const std::size_t first = training.rows.size();
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (b % folds == fold) continue;
    for (const PatchFeatures& patch : blocks[b]) training.rows.push_back(scaling.row(patch));
  }
  const auto added = static_cast<double>(training.rows.size() - first);
  training.labels.resize(training.rows.size(), label);
  training.weights.resize(training.rows.size(), added > 0 ? 0.5 / added : 0);
}

using Scores = std::vector<std::vector<double>>;  // [blocks][patches]

// Sorted scores of all blocks of a fold.
std::vector<double> sorted_scores(const Scores& scores, std::size_t fold, std::size_t folds) {
  std::vector<double> all;
  for (std::size_t b = fold; b < scores.size(); b += folds) {
    all.insert(all.end(), scores[b].begin(), scores[b].end());
  }
  std::sort(all.begin(), all.end());
  return all;
}

// Share of the sorted scores under the value; ties count half.
double share_under(const std::vector<double>& sorted, double value) {
  const auto low = std::lower_bound(sorted.begin(), sorted.end(), value);
  const auto high = std::upper_bound(low, sorted.end(), value);
  return (static_cast<double>(low - sorted.begin()) + 0.5 * static_cast<double>(high - low)) /
         static_cast<double>(sorted.size());
}

// The mean over the patches of a data set, and its squared error from the block sums of their
// distances from it.
struct ClusterMean {
  double mean = 0, variance = 0;
  std::size_t blocks = 0;
};

ClusterMean cluster_mean(const std::vector<std::vector<double>>& values) {
  ClusterMean result;
  double sum = 0, count = 0;
  for (const auto& block : values) {
    for (const double v : block) sum += v;
    count += static_cast<double>(block.size());
    if (!block.empty()) ++result.blocks;
  }
  if (count == 0) return result;
  result.mean = sum / count;
  for (const auto& block : values) {
    double rest = 0;
    for (const double v : block) rest += v - result.mean;
    result.variance += rest * rest / (count * count);
  }
  const auto blocks = static_cast<double>(result.blocks);
  if (result.blocks > 1) result.variance *= blocks / (blocks - 1);
  return result;
}

// Scores are compared within folds, since each has a classifier of its own.
std::vector<std::vector<double>> placements(const Scores& scores, const Scores& others,
                                            std::size_t folds, bool above) {
  std::vector<std::vector<double>> shares(scores.size());
  for (std::size_t fold = 0; fold < folds; ++fold) {
    const std::vector<double> sorted = sorted_scores(others, fold, folds);
    if (sorted.empty()) continue;
    for (std::size_t b = fold; b < scores.size(); b += folds) {
      for (const double score : scores[b]) {
        const double under = share_under(sorted, score);
        shares[b].push_back(above ? under : 1 - under);
      }
    }
  }
  return shares;
}

void set_interval(Auc& auc) {
  const double half = t_quantile(0.975, auc.freedom) * auc.error;
  auc.low = std::max(0.0, auc.value - half);
  auc.high = std::min(1.0, auc.value + half);
  auc.differs = auc.low > 0.5 || auc.high < 0.5;
}

Auc auc_of(const Scores& real, const Scores& simulated, std::size_t folds) {
  const ClusterMean a = cluster_mean(placements(real, simulated, folds, true));
  const ClusterMean b = cluster_mean(placements(simulated, real, folds, false));
  Auc auc;
  auc.value = (a.mean + b.mean) / 2;
  auc.error = std::sqrt(a.variance + b.variance);
  auc.freedom = std::max(1.0, static_cast<double>(std::min(a.blocks, b.blocks)) - 1);
  set_interval(auc);
  return auc;
}

// score(b, patch) of every patch of each block b.
template <class Score>
Scores scores_of(const Blocks& blocks, Score score) {
  Scores scores(blocks.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (const PatchFeatures& patch : blocks[b]) scores[b].push_back(score(b, patch));
  }
  return scores;
}

Auc auc_of(const Blocks& real, const Blocks& simulated, const Scaling& scaling,
           const std::vector<Weights>& betas) {
  const auto score = [&](std::size_t b, const PatchFeatures& patch) {
    return betas[b % betas.size()].dot(scaling.row(patch));
  };
  return auc_of(scores_of(real, score), scores_of(simulated, score), betas.size());
}

// Root mean square distance of the AUC from 1/2 if blocks are exchanged between the data sets and
// the classifiers are trained anew.
double spread_of_exchanges(const BlockStatistics& real, const BlockStatistics& simulated,
                           const Scaling& scaling, std::size_t folds, std::uint64_t seed,
                           const Workers& workers) {
  Blocks blocks = real.patches;
  blocks.insert(blocks.end(), simulated.patches.begin(), simulated.patches.end());
  const std::vector<BlockMoments> moments = moments_of(blocks, scaling);
  const std::size_t first = real.patches.size();
  const std::uint64_t key = mix64(mix64(seed) ^ name_key("exchanged patches"));
  std::vector<double> squares(kExchanges);
  workers.for_each(kExchanges, [&](std::size_t turn) {
    std::vector<std::size_t> order(blocks.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    shuffle_blocks(order, key, static_cast<std::uint32_t>(turn));
    std::vector<Weights> betas;
    for (std::size_t fold = 0; fold < folds; ++fold) {
      betas.push_back(first_step(moments, order, first, fold, folds));
    }
    Blocks a, b;
    for (std::size_t i = 0; i < order.size(); ++i) (i < first ? a : b).push_back(blocks[order[i]]);
    const double auc = auc_of(a, b, scaling, betas).value;
    squares[turn] = (auc - 0.5) * (auc - 0.5);
  });
  double sum = 0;
  for (const double square : squares) sum += square;
  return std::sqrt(sum / kExchanges);
}

struct PatchCount {
  std::size_t patches = 0, blocks = 0;
};

PatchCount count_of(const Blocks& blocks) {
  PatchCount amount;
  for (const auto& block : blocks) {
    amount.patches += block.size();
    if (!block.empty()) ++amount.blocks;
  }
  return amount;
}

bool share_a_fold(const Blocks& a, const Blocks& b, std::size_t folds) {
  const auto has_patches = [folds](const Blocks& blocks, std::size_t fold) {
    for (std::size_t block = fold; block < blocks.size(); block += folds) {
      if (!blocks[block].empty()) return true;
    }
    return false;
  };
  for (std::size_t fold = 0; fold < folds; ++fold) {
    if (has_patches(a, fold) && has_patches(b, fold)) return true;
  }
  return false;
}

}  // namespace

std::optional<ClassifierResult> classify(const BlockStatistics& real,
                                         const BlockStatistics& simulated, std::uint64_t seed,
                                         const Workers& workers) {
  const PatchCount a = count_of(real.patches), b = count_of(simulated.patches);
  if (std::min(a.patches, b.patches) < kLeastPatches || std::min(a.blocks, b.blocks) < 2) {
    return std::nullopt;
  }
  const std::size_t folds = std::min({kFolds, real.patches.size(), simulated.patches.size()});
  if (!share_a_fold(real.patches, simulated.patches, folds)) return std::nullopt;
  const Scaling scaling = scaling_of(real.patches, simulated.patches);
  std::vector<Weights> betas;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    Training training;
    add_training(real.patches, fold, folds, 1, scaling, training);
    add_training(simulated.patches, fold, folds, 0, scaling, training);
    betas.push_back(fitted(training));
  }
  ClassifierResult result;
  result.real_patches = a.patches;
  result.simulated_patches = b.patches;
  result.all = auc_of(real.patches, simulated.patches, scaling, betas);
  result.all.error = std::max(result.all.error,
                              spread_of_exchanges(real, simulated, scaling, folds, seed, workers));
  set_interval(result.all);
  for (std::size_t k = 0; k < kFeatures; ++k) {
    const auto feature = [k](std::size_t, const PatchFeatures& patch) { return patch[k]; };
    result.single.push_back(
        auc_of(scores_of(real.patches, feature), scores_of(simulated.patches, feature), 1));
  }
  return result;
}

}  // namespace ensonify
