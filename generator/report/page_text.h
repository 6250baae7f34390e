// The texts that a page consists of. Private to report/.
//
//   PageFile  page_files     the files of report/page as the build embeds them
//   PageFrame  page_frame    the page before and after the data
//   append_data              the data of a page, and its chunks
//   without_angles  colour_maps_json
//   PageContents  page_json  the data for a <script>, escaped so that no text ends it
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/json.h"
#include "formats/output_place.h"
#include "report/pictures.h"

namespace ensonify {

struct PageFile {
  const char* name;  // of the file, without extension
  const char* text;
};

// Sorted by name. Defined in a source that scripts/cmake/EmbedFiles.cmake writes.
std::span<const PageFile> page_files();

// First line of every page, which identifies it.
inline constexpr std::string_view kPageMark = "<!-- a page of ensonify report -->\n";

struct PageFrame {
  std::string before, after;
};

// `page`.html with its styles and scripts inserted, in the order of page/`order`.txt.
PageFrame page_frame(std::string_view page, std::string_view order);

void append_data(const std::string& json, const Chunks& chunks, StreamedFile& output);

// Inside a <script> the text ends at "</script" and nowhere else, and "<!--" changes what ends it.
std::string without_angles(const std::string& text);

// The stops of each color map of figures, by name.
Json colour_maps_json();

struct PageContents {
  const StoredDataset& dataset;
  const DatasetFacts& facts;
  const Survey& survey;
  const Look& look;
  const PictureBook& pictures;
  const std::vector<CodedStatistics>& statistics;
  bool preview = false;
};

std::string page_json(const PageContents& contents);

}  // namespace ensonify
