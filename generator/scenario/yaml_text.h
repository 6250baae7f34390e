// The text of a YAML file as such: what must be checked before and after yaml-cpp has read it,
// since yaml-cpp itself lets it pass.
//
//   is_clean_text     bytes that no YAML file should hold
//   is_unterminated   a quote that is never closed
//   indentation_trouble   what may be wrong with the indentation of a line
//   Columns  place_at_offset   places in characters
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/faults.h"

namespace ensonify {

// Refuses text that is too large, no UTF-8, or holds bytes that yaml-cpp would misread (0x04 ends
// its input) or that no editor shows. Without `has_lines` the faults are placed at the source
// alone.
bool is_clean_text(std::string_view text, int source, const std::string& path, bool has_lines,
                   Faults& faults);

// yaml-cpp lets the end of the text close a quote; such a scalar has swallowed the rest of the
// file. `offset` is that of the last quoted scalar, or of its anchor.
bool is_unterminated(std::string_view text, std::size_t offset);

// Where the indentation of the line (from 0) can be why yaml-cpp refuses it: what is wrong and what is
// accepted; else empty.
std::string indentation_trouble(std::string_view text, int line);

Place place_at_offset(int source, std::string_view text, std::size_t offset);

// yaml-cpp counts columns in bytes, people in characters.
class Columns {
 public:
  explicit Columns(std::string_view text);

  // Column, from 1, of the byte at `offset`, which is the byte `column_bytes` (from 0) of its line.
  int column(int offset, int column_bytes) const;

 private:
  std::vector<int> continuation_;  // offsets of the bytes that do not begin a character
};

}  // namespace ensonify
