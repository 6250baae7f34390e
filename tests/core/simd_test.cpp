#include "core/simd.h"

#include "catch.h"

using namespace ensonify;

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
