// What the user asks of a figure (figure.h).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ensonify {

enum class FigureView { cartesian, polar };
enum class FigureQuantity { level, clean, elevation, instance, semantic, shadow, multipath };

// Absent options have the defaults in docs/figures.md.
struct FigureOptions {
  std::filesystem::path dataset;
  std::filesystem::path output;  // its extension names the format: png, svg, webp, mp4
  std::optional<std::uint32_t> sequence;
  std::optional<std::uint32_t> ping;                             // of png and svg
  std::optional<std::pair<std::uint32_t, std::uint32_t>> pings;  // [first, last) of webp and mp4
  std::optional<double> fps;                                     // of webp and mp4
  FigureView view = FigureView::cartesian;
  FigureQuantity quantity = FigureQuantity::level;
  std::optional<std::array<double, 2>> db;  // of level and clean
  std::string colour_map;                   // empty: the quantity's own
  bool bilinear = false;                    // of level and clean
  bool outlines = false;                    // over level, clean and elevation
  std::vector<std::string> instances;       // only these are outlined or have a mask
  std::optional<std::string> title;         // UTF-8; "": none
  int width_px = 0;                         // 0: 1200, animated 800
  bool overwrite = false;
  bool (*stop)() = nullptr;  // called between pings
};

}  // namespace ensonify
