#include "core/parallel.h"

#include <atomic>
#include <stdexcept>
#include <vector>

#include "catch.h"
#include "core/runtime.h"

using namespace ensonify;

// Protects the promise under all others: every item once, whatever the number of threads.
TEST_CASE("for_each visits every item once") {
  for (const int threads : {1, 2, 7}) {
    std::vector<std::atomic<int>> visits(1000);
    Workers(threads).for_each(visits.size(), [&](std::size_t i) { ++visits[i]; });
    for (const auto& count : visits) REQUIRE(count == 1);
  }
}

TEST_CASE("for_each of nothing calls nothing") {
  bool called = false;
  Workers(2).for_each(0, [&](std::size_t) { called = true; });
  CHECK_FALSE(called);
}

// Protects against out-of-memory in a worker ending the process instead of the run.
TEST_CASE("an exception of one item reaches the caller") {
  CHECK_THROWS_AS(Workers(3).for_each(100,
                                      [](std::size_t i) {
                                        if (i == 57) throw std::runtime_error("57");
                                      }),
                  std::runtime_error);
}

TEST_CASE("zero threads means all of the machine") { CHECK(Workers(0).threads() >= 1); }

// Protects the command line's names, and the choice from a level that is not in the program.
TEST_CASE("levels of vector instructions have names that parse back") {
  for (const SimdLevel level : {SimdLevel::sse4, SimdLevel::avx2, SimdLevel::avx512}) {
    CHECK(parse_simd_level(simd_level_name(level)) == level);
  }
  CHECK(!parse_simd_level("avx"));
  CHECK(!parse_simd_level(""));
  CHECK(simd_level_name(SimdLevel::avx512) == "avx512");
  CHECK(best_simd_level() <= SimdLevel::avx512);
}
