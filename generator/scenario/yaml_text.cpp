#include "scenario/yaml_text.h"

#include <algorithm>

#include <fmt/format.h>

#include "scenario/text.h"
#include "scenario/yaml_tree.h"

namespace ensonify {
namespace {

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

}  // namespace

bool is_clean_text(std::string_view text, int source, const std::string& path, bool has_lines,
                   Faults& faults) {
  const auto refuse = [&](std::size_t offset, const char* what) {
    const Place at = has_lines ? place_at_offset(source, text, offset) : Place{source, 0, 0};
    add_fault(faults, at, path, what);
    return false;
  };
  if (text.size() > kMaxYamlBytes) {
    return refuse(0, fmt::format("larger than {} MiB", kMaxYamlBytes >> 20).c_str());
  }
  if (const auto nul = text.find('\0'); nul != std::string_view::npos) {
    return refuse(nul, "a NUL byte: this is no text file, YAML in UTF-8 is accepted");
  }
  if (const auto bad = first_invalid_utf8(text)) {
    return refuse(*bad, "not UTF-8, which is the only encoding accepted");
  }
  if (const auto bad = first_control_character(text, "\t\n\r")) {
    return refuse(*bad, "a control character or byte order mark, which no text should hold");
  }
  for (std::size_t i = text.find('\r'); i != std::string_view::npos; i = text.find('\r', i + 1)) {
    if (i + 1 >= text.size() || text[i + 1] != '\n') {
      return refuse(i, "a carriage return without line feed, which no text should hold");
    }
  }
  return true;
}

bool is_unterminated(std::string_view text, std::size_t offset) {
  std::size_t open = offset;
  if (text[open] == '&') open = text.find_first_of(" \t\r\n", open);
  open = text.find_first_not_of(" \t\r\n", open);
  if (open == std::string_view::npos || (text[open] != '"' && text[open] != '\'')) return false;
  const char quote = text[open];
  for (std::size_t i = open + 1; i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\') {
      ++i;
    } else if (text[i] == quote) {
      if (quote == '"' || i + 1 >= text.size() || text[i + 1] != quote) return false;
      ++i;
    }
  }
  return true;
}

Place place_at_offset(int source, std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t newline = before.rfind('\n');
  const std::size_t start = newline == std::string_view::npos ? 0 : newline + 1;
  int column = 1;
  for (const char c : before.substr(start)) {
    if (!is_continuation(c)) ++column;
  }
  return {source, static_cast<int>(line), column};
}

Columns::Columns(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (is_continuation(text[i])) continuation_.push_back(static_cast<int>(i));
  }
}

int Columns::column(int offset, int column_bytes) const {
  const auto from =
      std::lower_bound(continuation_.begin(), continuation_.end(), offset - column_bytes);
  const auto to = std::lower_bound(from, continuation_.end(), offset);
  return column_bytes + 1 - static_cast<int>(to - from);
}

}  // namespace ensonify
