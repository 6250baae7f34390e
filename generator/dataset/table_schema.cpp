#include "dataset/table_schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstdint>

#include "dataset/json.h"
#include "dataset/schema.h"

namespace ensonify {
namespace {

Column column_of(const Json& field) {
  Column column;
  column.name = field.at("name").get<std::string>();
  const std::string type = field.at("type").get<std::string>();
  if (type == "integer") column.type = ColumnType::integer;
  if (type == "number") column.type = ColumnType::number;
  const Json& constraints = field.at("constraints");
  column.minimum = number_at(constraints, "minimum");
  if (const Json* words = member(constraints, "enum")) {
    column.words = words->get<std::vector<std::string>>();
  }
  return column;
}

template <class Number>
std::optional<Number> read(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string cell_fault(const Column& column, std::string_view cell) {
  if (column.type == ColumnType::text) {
    const auto& words = column.words;
    if (words.empty() || std::find(words.begin(), words.end(), cell) != words.end()) return {};
    return fmt::format("is none of {}", fmt::join(words, ", "));
  }
  if (column.type == ColumnType::integer && !read<std::int64_t>(cell)) return "is no integer";
  const auto number = read<double>(cell);
  if (!number) return "is no number";
  if (column.minimum && *number < *column.minimum) {
    return fmt::format("is below {}", *column.minimum);
  }
  return {};
}

}  // namespace

std::optional<TableSchema> table_schema(std::string_view file_name) {
  const auto json = parse_json(schema_text("tables"));
  const Json* table = json ? member(json->at("tables"), file_name) : nullptr;
  if (table == nullptr) return std::nullopt;
  TableSchema columns;
  for (const Json& field : table->at("fields")) columns.push_back(column_of(field));
  return columns;
}

std::string header_fault(const TableSchema& table, std::string_view line) {
  std::string header;
  for (const Column& column : table) header += (header.empty() ? "" : ",") + column.name;
  return line == header ? "" : "does not begin with " + header;
}

std::string row_fault(const TableSchema& table, std::string_view line) {
  const auto cells = columns_of(line, ',');
  if (cells.size() != table.size()) {
    return fmt::format("has {} columns, not {}", cells.size(), table.size());
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string fault = cell_fault(table[i], cells[i]);
    if (!fault.empty()) return fmt::format("{} `{}` {}", table[i].name, cells[i], fault);
  }
  return {};
}

std::vector<std::string_view> columns_of(std::string_view line, char separator) {
  std::vector<std::string_view> columns;
  for (std::size_t start = 0; start <= line.size();) {
    const std::size_t end = std::min(line.find(separator, start), line.size());
    columns.push_back(line.substr(start, end - start));
    start = end + 1;
  }
  return columns;
}

bool is_number(std::string_view text) { return read<double>(text).has_value(); }

}  // namespace ensonify
