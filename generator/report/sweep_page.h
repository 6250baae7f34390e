// A sweep as one page: the table of its runs, numbers against axes, and an image of each run with
// one display. Private to report/.
//
//   WrittenSweep  write_sweep_page
#pragma once

#include <cstdint>
#include <filesystem>

#include "core/error.h"
#include "core/parallel.h"
#include "sweep/folder.h"

namespace ensonify {

struct WrittenSweep {
  std::uint64_t runs = 0, shown = 0;  // of the plan; with an image
  std::uint64_t bytes = 0;            // of the page
};

// Errors: usage (the folder has no plan), io, interrupted. A run whose files cannot be read is
// shown as damaged.
Result<WrittenSweep> write_sweep_page(const std::filesystem::path& sweep, const SweepHead& head,
                                      const std::filesystem::path& page, const Workers& workers,
                                      bool (*stop)());

}  // namespace ensonify
