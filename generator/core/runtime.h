// Files and processor features of the machine at run time.
//
//   companion_path    where a file is that the program starts or opens: the importer, the modules
//   module_symbol     a function of a module, which is opened for it
//   SimdLevel  best_simd_level  simd_level_name  parse_simd_level
//                     which vector instructions the inner loops use. One program holds all levels
//                     and chooses at run time; results differ between levels by rounding only
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/error.h"

namespace ensonify {

// The file of this name in the folder ENSONIFY_COMPANIONS of the environment, which ctest sets for
// test programs. Otherwise in the folder of the program or of the Python module, as in a build
// tree, or in the folder of an installation: ../lib/ensonify from the program's folder,
// ../../../ensonify from the module's. If no such file exists, returns the path in the first
// folder.
std::filesystem::path companion_path(const char* name);

// A module is a shared library that is opened when something needs it and never closed. What few
// commands need is in modules, since the libraries below it would be linked at every start.
// Error (device): it is missing, or cannot be opened since a library that it needs is missing:
// `advice` says what to install.
Result<void*> module_symbol(const std::filesystem::path& module, const char* symbol,
                            const std::string& advice);

enum class SimdLevel { sse4, avx2, avx512 };  // avx2 with fma; avx512 with f, bw, dq and vl

// The highest level that this processor has.
SimdLevel best_simd_level();

// "sse4", "avx2", "avx512".
std::string_view simd_level_name(SimdLevel level);
std::optional<SimdLevel> parse_simd_level(std::string_view name);

}  // namespace ensonify
