// A data set as one self-contained page of HTML.
//
//   write_report   the page of a finished data set
#pragma once

#include <cstdint>
#include <filesystem>

#include "core/error.h"

namespace ensonify {

struct ReportOptions {
  std::filesystem::path dataset;
  std::filesystem::path output;  // empty: beside the data set, DIR_report.html
  int max_pings = 200;           // of more, this many are shown, spread evenly
  int threads = 0;
  bool overwrite = false;    // another file than a page of ours may be replaced
  bool preview = false;      // the page says that it shows a preview
  bool (*stop)() = nullptr;  // asked between pings
};

struct ReportSummary {
  std::filesystem::path output;
  std::uint64_t pings = 0, shown = 0;
  std::uint64_t bytes = 0;
};

// Error kinds: usage (no finished data set; the output is not ours to replace), io, interrupted.
Result<ReportSummary> write_report(const ReportOptions& options);

}  // namespace ensonify
