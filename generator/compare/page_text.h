// A comparison as one self-contained page of HTML: text, inline SVG and images, without scripts.
// Private to compare/.
//
//   ExampleImage  example_pings  example_crops
//   ComparePart  compare_parts   the files that the build embeds
//   kComparePageMark             first line of every page, which identifies it
//   ComparePage  comparison_page
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compare/compare.h"
#include "compare/pings.h"
#include "core/error.h"

namespace ensonify {

// 8-bit levels: from 20 dB under to 30 dB over the median level of the data set's examples.
struct ExampleImage {
  int rows = 0, columns = 0;
  std::vector<std::uint8_t> pixels;
};

// Of the first, middle and last, with sides of at most 360 pixels.
std::vector<ExampleImage> example_pings(const PolarPings& pings);
std::vector<ExampleImage> example_crops(const Crops& crops);

struct ComparePart {
  const char* name;  // of the file, without extension
  const char* text;
};
std::span<const ComparePart> compare_parts();

inline constexpr std::string_view kComparePageMark = "<!-- a page of ensonify compare -->\n";

struct ComparePage {
  const Comparison& comparison;
  const std::string &real, &simulated;  // their folders
  const std::vector<ExampleImage>&real_examples, &simulated_examples;
};

Result<std::string> comparison_page(const ComparePage& page);

// Text with the characters of HTML escaped.
std::string html_text(std::string_view text);

// A plot as an SVG element: of a curve with 95 % bands, and of the histograms.
std::string curve_svg(const ComparedStatistic& statistic);
std::string histogram_svg(const Comparison& comparison);

}  // namespace ensonify
