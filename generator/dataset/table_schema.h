// The CSV tables as tables.json describes them. Private to dataset/.
//
//   table_schema               of a table, by its file's name
//   header_fault  row_fault    a line against it
//   columns_of  is_number      parts of a line
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ensonify {

enum class ColumnType { integer, number, text };

struct Column {
  std::string name;
  ColumnType type = ColumnType::text;
  std::optional<double> minimum;
  std::vector<std::string> words;  // accepted ones; empty: any text
};

using TableSchema = std::vector<Column>;

// None where tables.json does not describe it.
std::optional<TableSchema> table_schema(std::string_view file_name);

// Empty where the line is as it should be, else what is wrong.
std::string header_fault(const TableSchema& table, std::string_view line);
std::string row_fault(const TableSchema& table, std::string_view line);

std::vector<std::string_view> columns_of(std::string_view line, char separator);
bool is_number(std::string_view text);

}  // namespace ensonify
