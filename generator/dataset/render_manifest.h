// Renders of a data set: 8-bit images that `ensonify render` made from its levels, in renders/NAME,
// with their own manifest, which no other manifest lists.
//
//   ShownPart                          the pixels that a render shows
//   RenderedSequence  RenderManifest   render.json without its list of files
//   render_json  read_render_head      ... as JSON
//   render_schema                      ... its JSON Schema, without titles and meanings
//   render_folder  render_file  is_render_name
//   render_names                       existing renders
//   read_render                        one of a finished data set
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/display.h"
#include "core/error.h"
#include "dataset/read_dataset.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {

// How a block of polar pixels becomes one: the level of the pixel in its middle, or the largest.
enum class Decimation { pick, max };
constexpr const char* decimation_name(Decimation decimation) {
  return decimation == Decimation::pick ? "pick" : "max";
}

struct ShownPart {
  std::optional<std::array<double, 2>> range_m;  // slant ranges [from, to]; absent: all
  std::uint32_t samples = 1, beams = 1;          // of a block
  Decimation decimation = Decimation::pick;
  bool decimates() const { return samples > 1 || beams > 1; }
  bool is_whole() const { return !range_m && !decimates(); }
};

// Of an image among those of the data set, in pixels of the data set; `height_px` and `width_px`
// are the size of the rendered image.
struct PartPixels {
  std::uint64_t top_px = 0, left_px = 0, height_px = 0, width_px = 0;
};

struct RenderedSequence {
  std::uint32_t sequence = 0;
  std::uint32_t first_ping = 0, last_ping = 0;  // [first, last)
  std::string sha256;                           // of its sequence.json
  std::optional<PartPixels> polar, cartesian;   // of rendered views, unless they are whole
};

struct RenderManifest {
  std::uint64_t version = 1;
  std::string name;
  std::string program_version, program_commit;
  std::vector<std::string> views;  // polar, cartesian
  Display display;
  DisplayCounts counts;
  ShownPart part;
  std::uint32_t jpeg_quality = 0;  // 0: PNG
  std::uint64_t bytes = 0;         // of all its files
  std::vector<RenderedSequence> sequences;
  std::string fault;  // when read: the first member of a wrong kind; empty: none
};

Json render_json(const RenderManifest& manifest, const std::vector<FileEntry>& files);
Json render_schema();
// None if it is not a render.json.
std::optional<RenderManifest> read_render_head(const Json& head);

// At most 64 letters, digits, `-`, `_` and `.`, not starting with `.`.
bool is_render_name(std::string_view name);
// renders/NAME, relative to the data set.
std::string render_folder(std::string_view name);
// sequences/000000/000003_polar.png, or .jpg, relative to the render's folder.
std::string render_file(ImageView view, std::uint32_t sequence, std::uint32_t ping, bool jpeg);

// Sorted folders in renders/, complete or not; without links.
std::vector<std::string> render_names(const std::filesystem::path& dir);

// Errors (usage): no render has this name, it is incomplete, or the data set no longer has the
// sequences from which it was made; (io) its manifest is damaged.
Result<RenderManifest> read_render(const StoredDataset& dataset, const std::string& name);

}  // namespace ensonify
