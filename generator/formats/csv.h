// Tables as text, one row per line, without quotes around numbers.
//
//   columns_of                   the cells of a row
//   parse_number  read_numbers   a text that is a number; a row of numbers
//   csv_cell  csv_rows           a text as a cell (RFC 4180); all cells of a table, unquoted
#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ensonify {

inline std::vector<std::string_view> columns_of(std::string_view line, char separator) {
  std::vector<std::string_view> columns;
  for (std::size_t start = 0; start <= line.size();) {
    const std::size_t end = std::min(line.find(separator, start), line.size());
    columns.push_back(line.substr(start, end - start));
    start = end + 1;
  }
  return columns;
}

template <class Number>
std::optional<Number> parse_number(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Fills all of `values` from comma-separated numbers; false if their count differs or one is not a
// number.
inline bool read_numbers(std::string_view line, std::span<double> values) {
  const std::vector<std::string_view> cells = columns_of(line, ',');
  if (cells.size() != values.size()) return false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = parse_number<double>(cells[i]);
    if (!value) return false;
    values[i] = *value;
  }
  return true;
}

inline std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\n\r") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + "\"";
}

inline std::vector<std::vector<std::string>> csv_rows(std::string_view text) {
  std::vector<std::vector<std::string>> rows;
  bool quoted = false, fresh = true;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (fresh) rows.emplace_back(1);
    fresh = false;
    const char c = text[i];
    // Two quotes within a cell in quotes stand for one.
    const bool twice = quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"';
    if (twice) ++i;
    if (c == '"' && !twice) {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      rows.back().emplace_back();
    } else if (c == '\n' && !quoted) {
      fresh = true;
    } else {
      rows.back().back() += c;
    }
  }
  return rows;
}

}  // namespace ensonify
