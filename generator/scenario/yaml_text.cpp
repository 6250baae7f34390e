#include "scenario/yaml_text.h"

#include <algorithm>

#include <fmt/format.h>

#include "scenario/text.h"

namespace ensonify {
namespace {

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

std::vector<std::string_view> lines_until(std::string_view text, int line) {
  std::vector<std::string_view> lines;
  while (static_cast<int>(lines.size()) <= line && !text.empty()) {
    const std::size_t end = text.find('\n');
    lines.push_back(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

// npos for an empty line or a comment.
std::size_t indentation_of(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  return first == std::string_view::npos || line[first] == '#' ? std::string_view::npos : first;
}

// In spaces, after the dashes of list items, where their maps begin.
std::size_t inner_indentation(std::string_view line, std::size_t at) {
  while (line.substr(at).starts_with("- ")) {
    const std::size_t next = line.find_first_not_of(' ', at + 1);
    if (next == std::string_view::npos) break;
    at = next;
  }
  return at;
}

// A key alone, a list item alone, or a value that continues on the next line.
bool opens_more(std::string_view line) {
  const std::size_t comment = line.find(" #");
  line = line.substr(0, comment);
  const std::size_t last = line.find_last_not_of(" \t\r");
  return last != std::string_view::npos &&
         std::string_view(":-,[{|>").find(line[last]) != std::string_view::npos;
}

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
    return refuse(nul, "a NUL byte, which a text file does not have; expected YAML in UTF-8");
  }
  if (const auto bad = first_invalid_utf8(text)) {
    return refuse(*bad, "the text is not UTF-8; expected YAML in UTF-8");
  }
  if (const auto bad = first_control_character(text, "\t\n\r")) {
    return refuse(*bad, "a control character or byte order mark; expected printable text");
  }
  for (std::size_t i = text.find('\r'); i != std::string_view::npos; i = text.find('\r', i + 1)) {
    if (i + 1 >= text.size() || text[i + 1] != '\n') {
      return refuse(i, "a carriage return without a line feed; expected line feeds");
    }
  }
  return true;
}

std::string indentation_trouble(std::string_view text, int line) {
  const std::vector<std::string_view> lines = lines_until(text, line);
  if (line < 0 || static_cast<int>(lines.size()) <= line) return "";
  const std::string_view own = lines.back();
  const std::size_t at = indentation_of(own);
  if (at == std::string_view::npos) return "";
  if (own.substr(0, at).find('\t') != std::string_view::npos) {
    return "the line is indented with a tab; expected spaces";
  }
  std::vector<std::size_t> open;  // indentations of the open maps and lists
  for (auto above = lines.rbegin() + 1; above != lines.rend(); ++above) {
    const std::size_t indentation = indentation_of(*above);
    if (indentation == std::string_view::npos) continue;
    const std::size_t inner = inner_indentation(*above, indentation);
    if (open.empty() && at > inner && !opens_more(*above)) {
      return fmt::format(
          "the line is indented by {} spaces, but the key above, indented by {}, already has a "
          "value; expected all keys of a map in the same column",
          at, inner);
    }
    for (const std::size_t level : {inner, indentation}) {
      if (open.empty() || level < open.back()) open.push_back(level);
    }
  }
  if (open.empty() || std::find(open.begin(), open.end(), at) != open.end() || at > open.front()) {
    return "";
  }
  return fmt::format("the line is indented by {}; expected an indentation of {}",
                     at == 1 ? "1 space" : fmt::format("{} spaces", at), fmt::join(open, ", "));
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
