// Exports a finished data set to another format.
//
//   ExportTrait  ExportFormat
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

enum ExportTrait : unsigned {
  kIsFile = 1,          // OUT becomes a file, not a folder
  kSimulated = 2,       // needs labels, time series or the vertical fan, which recordings lack
  kListsObjects = 4,    // and takes the options that select objects
  kPolarImages = 8,     // shows these only
  kGrayImages = 16,     // holds 8-bit levels, so that a render has no colors
  kExactImages = 32,    // ... nor errors of JPEG
  kOfCamera = 128,      // makes something of a camera of a rig
  kOfNavigation = 256,  // ... of navigation of a rig
  kOneOfRuns = 64,      // holds all runs of a sweep at once, with their ids in names or records
};

struct ExportFormat {
  const char* name;
  const char* what;
  unsigned traits;
  const char* options;  // other options that it takes, as on the command line
  Status (*write)(const ExportJob& job, const std::filesystem::path& target);

  constexpr bool has(ExportTrait trait) const { return (traits & trait) != 0; }
};

std::span<const ExportFormat> export_formats();
// Null if there is none.
const ExportFormat* find_export_format(std::string_view name);

struct ExportReport {
  std::uint64_t sequences = 0, pings = 0;
  std::uint64_t runs = 0, left_out = 0;  // of a sweep: exported, and not done; 0: of a data set
};

// Of a sweep with a table (runs.csv), the runs that are done in it: in one data set, if the format
// can hold them, otherwise each in a folder or file with its id; and the table.
//
// `output` appears whole, by rename, or not at all. Errors: (usage) not a finished data set, an
// output that is not empty, an option or a data set that the format cannot take; (io) a damaged
// file, or reading or writing failed; (interrupted).
Result<ExportReport> export_dataset(const ExportFormat& format, const ExportOptions& options);

}  // namespace ensonify
