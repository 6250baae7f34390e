// What the user asks of an export (export.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

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

}  // namespace ensonify
