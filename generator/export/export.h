// Exports a finished data set to another format.
//
//   export_formats      name, description and options of each
//   find_export_format  by name
//   export_dataset      writes one of them
//
// Pings are read one after another: memory does not grow with the data set. The same data set gives
// the same bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "core/error.h"
#include "export/options.h"

namespace ensonify {

struct ExportJob;

struct ExportFormat {
  const char* name;
  const char* what;
  bool is_folder;       // what OUT becomes
  bool simulated_only;  // needs labels, time series or the vertical fan, which recordings lack
  bool lists_objects;   // and takes the options that select objects
  const char* options;  // other options that it takes, as on the command line
  Status (*write)(const ExportJob& job, const std::filesystem::path& target);
};

std::span<const ExportFormat> export_formats();
// Null if there is none.
const ExportFormat* find_export_format(std::string_view name);

struct ExportReport {
  std::uint64_t sequences = 0, pings = 0;
};

// `output` appears whole, by rename, or not at all. Errors: (usage) not a finished data set, an
// output that is not empty, an option or a data set that the format cannot take; (io) a damaged
// file, or reading or writing failed; (interrupted).
Result<ExportReport> export_dataset(const ExportFormat& format, const ExportOptions& options);

}  // namespace ensonify
