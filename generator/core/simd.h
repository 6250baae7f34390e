// Which vector instructions the inner loops use. One program holds all levels and chooses at run
// time; results differ between levels by rounding only.
#pragma once

#include <optional>
#include <string_view>

namespace ensonify {

enum class SimdLevel { sse4, avx2, avx512 };  // avx2 with fma; avx512 with f, bw, dq and vl

// The highest level that this processor has.
SimdLevel best_simd_level();

// "sse4", "avx2", "avx512".
std::string_view simd_level_name(SimdLevel level);
std::optional<SimdLevel> parse_simd_level(std::string_view name);

}  // namespace ensonify
