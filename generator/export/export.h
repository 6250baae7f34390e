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
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/ping.h"

namespace ensonify {

using PictureView = ImageView;
enum class YoloLabels { segments, boxes };

// Absent options have the defaults in docs/export.md. An option that a format does not take is an
// error.
struct ExportOptions {
  std::filesystem::path dataset;
  std::filesystem::path output;
  std::optional<PictureView> view;             // which image of a ping
  std::optional<YoloLabels> labels;            // of yolo
  bool stack = false;                          // hdf5: all sequences in one array
  bool pad = false;                            // ... of the size of the largest
  bool one_file = false;                       // mcap: all sequences, one after another
  std::optional<std::uint64_t> shard_size_mb;  // of webdataset, 10^6 bytes
  std::optional<int> margin_px;                // of crops: around the box, on each side
  std::optional<std::string> split;            // train, val or test; absent: all
  // Classes whose objects get a box; absent: all of kind thing.
  std::optional<std::vector<std::string>> classes;
  std::vector<std::string> exclude;         // ... but not of these
  std::optional<std::uint64_t> min_pixels;  // of the mask
  std::optional<double> min_visible;        // least share of the amodal mask, 0 to 1
  std::optional<double> full_scale_db;      // level of the largest count, or of amplitude 1
  std::optional<std::string> render;        // 8-bit images of this render instead of png/
  // Called between pings; true ends the export with ErrorKind::interrupted and leaves no files.
  std::function<bool()> stop;
};

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
