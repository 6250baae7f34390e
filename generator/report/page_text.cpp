#include "report/page_text.h"

#include <algorithm>
#include <sstream>

#include "core/error.h"
#include "report/page_files.h"

namespace ensonify {
namespace {

std::string_view text_of(std::string_view name) {
  for (const PageFile& file : page_files()) {
    if (file.name == name) return file.text;
  }
  ENSONIFY_ASSERT(!"a file of the page is not in the program");
  return {};
}

// All files of order.txt that end like this, one behind the other.
std::string files_with(std::string_view extension) {
  std::istringstream order{std::string(text_of("order"))};
  std::string all;
  for (std::string line; std::getline(order, line);) {
    if (!std::string_view(line).ends_with(extension)) continue;
    all += text_of(std::string_view(line).substr(0, line.size() - extension.size()));
    all += '\n';
  }
  return all;
}

struct Cut {
  std::string_view before, after;
};

// At the line that holds nothing but the mark.
Cut cut_at(std::string_view text, std::string_view mark) {
  const auto at = text.find(mark);
  ENSONIFY_ASSERT(at != std::string_view::npos);
  return {text.substr(0, at), text.substr(at + mark.size())};
}

}  // namespace

PageFrame page_frame() {
  const Cut styles = cut_at(text_of("page"), "@styles@\n");
  const Cut data = cut_at(styles.after, "@data@\n");
  const Cut scripts = cut_at(data.after, "@scripts@\n");
  PageFrame frame;
  frame.before = std::string(kPageMark);
  frame.before += styles.before;
  frame.before += files_with(".css");
  frame.before += data.before;
  frame.after = scripts.before;
  frame.after += files_with(".js");
  frame.after += scripts.after;
  return frame;
}

}  // namespace ensonify
