// The classifier on features whose separation is known.
#include "compare/classifier.h"

#include <cmath>

#include "catch.h"
#include "core/random.h"

namespace ensonify {
namespace {

// Independent normal features; one of them shifted.
BlockStatistics patches_of(std::uint64_t seed, double shift) {
  BlockStatistics statistics;
  for (std::uint64_t b = 0; b < 10; ++b) {
    std::vector<PatchFeatures> block;
    for (std::uint64_t i = 0; i < 60; ++i) {
      PatchFeatures patch{};
      for (std::size_t k = 0; k < kFeatures; ++k) {
        const auto xi = complex_normal(stream_key(seed, Stream::speckle, 0),
                                       static_cast<std::uint32_t>(b), i,
                                       static_cast<std::uint32_t>(k));
        patch[k] = std::sqrt(2.0) * xi.re + (k == 3 ? shift : 0);
      }
      block.push_back(patch);
    }
    statistics.patches.push_back(std::move(block));
  }
  return statistics;
}

}  // namespace

TEST_CASE("equal patches cannot be told apart", "[compare]") {
  const auto result = classify(patches_of(1, 0), patches_of(2, 0), 0, Workers(2));
  REQUIRE(result.has_value());
  CHECK(std::abs(result->all.value - 0.5) < 3 * result->all.error);
  CHECK(result->all.error < 0.03);
}

TEST_CASE("a shifted feature has the AUC of the binormal model", "[compare]") {
  const auto result = classify(patches_of(1, 1), patches_of(2, 0), 0, Workers(2));
  REQUIRE(result.has_value());
  const double truth = 0.5 * std::erfc(-1 / std::sqrt(2.0) / std::sqrt(2.0));  // Phi(1/sqrt 2)
  CHECK(std::abs(result->single[3].value - truth) < 4 * result->single[3].error);
  // Of 12 features 11 are noise: a little is lost.
  CHECK(result->all.value > truth - 0.04);
  CHECK(result->all.value < truth + 0.04);
  CHECK(result->all.differs);
  CHECK(result->single[3].differs);
}

TEST_CASE("few patches are no data", "[compare]") {
  BlockStatistics few = patches_of(1, 0);
  few.patches.resize(1);
  CHECK_FALSE(classify(few, patches_of(2, 0), 0, Workers(1)).has_value());
}

}  // namespace ensonify
