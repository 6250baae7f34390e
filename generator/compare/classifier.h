// A classifier told to tell patches of two data sets apart. Private to compare/.
//
//   Auc  ClassifierResult  classify
//
// Logistic regression with a ridge penalty on standardized features, by iteratively reweighted
// least squares (McCullagh & Nelder, "Generalized linear models", 1989). Patches of one block are
// either all trained on or all tested on. AUC: the probability that a patch of the first data set
// has the higher score; its error follows from the means of the placements by blocks (DeLong et
// al. 1988, for clustered data Obuchowski 1997). That leaves out what the folds share, since they
// are trained on nearly the same patches: the error of the classifier is not less than the spread
// of the AUC over 200 exchanges of blocks between the data sets, each with classifiers trained
// anew, by the first step of the regression.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compare/block_statistics.h"
#include "core/parallel.h"

namespace ensonify {

struct Auc {
  double value = 0.5, error = 0, low = 0, high = 1;
  double freedom = 1;    // degrees, of the error
  bool differs = false;  // 0.5 lies outside the 95 % interval
};

struct ClassifierResult {
  Auc all;
  std::vector<Auc> single;  // of each feature alone, in the order of feature_names()
  std::size_t real_patches = 0, simulated_patches = 0;
};

// None if either has fewer than 20 patches, patches in fewer than 2 blocks, or no fold with patches
// of both.
std::optional<ClassifierResult> classify(const BlockStatistics& real,
                                         const BlockStatistics& simulated, std::uint64_t seed,
                                         const Workers& workers);

}  // namespace ensonify
