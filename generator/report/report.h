// A data set, or the runs of a sweep, as one self-contained page of HTML; a rig as a page with a
// page of each instrument.
//
//   PreviewOf      the sequence from which a preview takes its pings
//   write_report   the page of a finished data set, of a sweep or of a rig
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/error.h"
#include "core/vec.h"

namespace ensonify {

// A preview's data set holds one sequence, whose pings are numbered from 0.
struct PreviewOf {
  std::vector<std::uint32_t> pings;  // their numbers in the whole sequence, in order
  std::vector<Vec3> path_m;          // of the sonar through all of it
  std::uint64_t all_pings = 0;       // of all of it
};

struct ReportOptions {
  std::filesystem::path dataset;
  std::filesystem::path output;  // empty: next to the data set, DIR_report.html
  std::optional<int> max_pings;  // larger data sets show this many, spread evenly; 200
  int threads = 0;
  bool overwrite = false;    // may replace files other than pages of ensonify
  bool preview = false;      // the page says that it shows a preview
  PreviewOf preview_of;      // used only for a preview
  bool (*stop)() = nullptr;  // asked between pings
};

struct ReportSummary {
  std::filesystem::path output;
  std::uint64_t pings = 0, shown = 0;
  std::uint64_t bytes = 0;
  std::uint64_t runs = 0;  // of a sweep, `shown` of which have an image; 0: a data set
};

// Error kinds: usage (neither a finished data set, a sweep nor a rig, or the output may not be
// replaced), io, interrupted.
Result<ReportSummary> write_report(const ReportOptions& options);

}  // namespace ensonify
