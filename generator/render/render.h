// Makes 8-bit images of a finished data set again, with another display.
//
//   RenderOptions  RenderReport  render_dataset
//
// Processes sequences and pings in parallel; the bytes do not depend on the number of threads. Only
// reads the files of the data set itself.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "core/display.h"
#include "core/error.h"
#include "core/ping.h"
#include "dataset/render_manifest.h"

namespace ensonify {

struct RenderOptions {
  std::filesystem::path dataset;
  std::string name;               // of the render
  std::optional<ImageView> view;  // absent: every view that the data set has a grid of
  Display display;                // but for its limits
  ShownPart part;
  std::uint32_t jpeg_quality = 0;  // 1 to 100; 0: PNG
  // Absent: those of the data set's own images where these have the same time-varied gain; else
  // default_limits_db (labels/display.h) of the first pings of the first few rendered sequences.
  std::optional<std::array<double, 2>> limits_db;
  std::optional<std::pair<std::uint32_t, std::uint32_t>> sequences;  // [first, last); absent: all
  bool overwrite = false;  // replaces a finished render of this name
  int threads = 0;         // 0: all that the machine has
  std::string program_version, program_commit;
  // Called between pings; true ends the work with ErrorKind::interrupted. The images so far are not
  // a render: the same call starts again.
  std::function<bool()> stop;
};

struct RenderReport {
  std::filesystem::path folder;
  std::uint64_t sequences = 0, pings = 0;
  Display display;  // with its limits
  DisplayCounts counts;
};

// Writes renders/NAME of the data set: an image of every view and ping, then render.json. Errors:
// (usage) not a finished data set, no levels or grid, a bad name, display or part, an existing
// render, or a foreign file in its place; (io) a damaged file, or reading or writing failed;
// (interrupted).
Result<RenderReport> render_dataset(const RenderOptions& options);

}  // namespace ensonify
