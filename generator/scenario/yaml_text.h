// Checks of a YAML text that must happen before and after yaml-cpp reads it, because yaml-cpp does
// not report these errors.
//
//   is_clean_text     bytes that a YAML file should not contain
//   is_unterminated   a quote that is never closed
//   indentation_trouble   likely errors in the indentation of a line
//   Columns  place_at_offset   places in characters
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/faults.h"

namespace ensonify {

// The same as ReadLimits (faults.h).
inline constexpr std::size_t kMaxYamlBytes = 16u << 20;

// Refuses text that is too large, is not UTF-8, or contains bytes that yaml-cpp misreads (0x04 ends
// its input) or that no editor shows. Without `has_lines` the errors have only the source as place.
bool is_clean_text(std::string_view text, int source, const std::string& path, bool has_lines,
                   Faults& faults);

// In yaml-cpp the end of the text closes an open quote, and the scalar swallows the rest of the
// file. `offset` is that of the last quoted scalar, or of its anchor.
bool is_unterminated(std::string_view text, std::size_t offset);

// If the indentation of the line (from 0) can be why yaml-cpp refuses it: what is wrong and what is
// expected. Otherwise empty.
std::string indentation_trouble(std::string_view text, int line);

Place place_at_offset(int source, std::string_view text, std::size_t offset);

// yaml-cpp counts columns in bytes; messages count characters.
class Columns {
 public:
  explicit Columns(std::string_view text);

  // The column, from 1, of the byte at `offset`, which is byte `column_bytes` (from 0) of its line.
  int column(int offset, int column_bytes) const;

 private:
  std::vector<int> continuation_;  // offsets of bytes that do not begin a character
};

}  // namespace ensonify
