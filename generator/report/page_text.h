// The page around its data. Private to report/.
//
//   PageFrame  page_frame   what stands before and behind the data
#pragma once

#include <string>
#include <string_view>

namespace ensonify {

// First line of every page: what tells it from a stranger's file.
inline constexpr std::string_view kPageMark = "<!-- a page of ensonify report -->\n";

struct PageFrame {
  std::string before, after;
};

// page.html with styles and scripts put in, in the order of page/order.txt.
PageFrame page_frame();

}  // namespace ensonify
