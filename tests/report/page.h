// A page taken apart again, and data sets to make pages of.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/read_dataset.h"
#include "report/report.h"
#include "scenario/scenario.h"
#include "temporary_folder.h"

namespace ensonify::test {

// A ball before a wall, heard over noise: masks, shadows, elevations and speckle.
inline constexpr const char* kScene = R"(ensonify: 1
name: page
seed: 7
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 4
  beams: {count: 48, fov_deg: 48}
  rays: {elevation: 16}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: wall, class: wall, material: m, shape: {box: {size_m: [0.5, 8, 4]}}, pose: {position_m: [3.3, 0, 0], rotation_deg: [0, 30, 0]}}
  - {name: ball, class: ball, material: m, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [1.5, 0, 0]}}
trajectory: {ping_rate_hz: 5, pings: 4}
noise: {spectrum_level_db: 30}
output: {cartesian: false, png: false}
)";

// The folder of a data set of `scene` in `folder`.
std::filesystem::path make_set(const TemporaryFolder& folder, const std::string& name,
                               const std::string& scene,
                               const std::vector<Override>& overrides = {});

struct Page {
  std::string text;                 // of the whole file
  nlohmann::json json;              // of the report
  std::vector<std::string> chunks;  // as bytes
};

Page read_page(const std::filesystem::path& path);

// Writes it beside the data set, and reads it.
Page page_of(const std::filesystem::path& set, int max_pings = 200, int threads = 2);

struct Picture {
  int width = 0, height = 0;
  std::vector<std::array<std::uint8_t, 3>> pixels;  // red, green, blue
};

Picture decode(const std::string& webp);
// The chunk that stands there: a number.
Picture picture_at(const Page& page, const nlohmann::json& number);

struct OpenSet {
  StoredDataset dataset;
  std::vector<StoredSequence> sequences;
};
OpenSet open_set(const std::filesystem::path& set);

}  // namespace ensonify::test
