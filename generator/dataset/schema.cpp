#include "dataset/schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <vector>

#include "core/counted.h"
#include "core/error.h"
#include "formats/csv.h"
#include "formats/json.h"

namespace ensonify {
namespace {

// Valijson supports only nlohmann::json, whose keys are sorted.
using SortedJson = nlohmann::json;
using Adapter = valijson::adapters::NlohmannJsonAdapter;
using SchemaError = valijson::ValidationResults::Error;

constexpr std::size_t kMaxFaults = 3;
constexpr std::size_t kMaxShown = 60;

// An error that only follows from a nested one.
bool is_consequence(const SchemaError& error) {
  return error.description.starts_with("Failed to validate") ||
         error.description.starts_with("Cannot validate");
}

// Pointer to the value of an error's context, whose parts are <root>, then [key] or [index].
SortedJson::json_pointer pointer_of(const SchemaError& error) {
  SortedJson::json_pointer pointer;
  for (std::size_t i = 1; i < error.context.size(); ++i) {
    const std::string& part = error.context[i];
    pointer.push_back(part.substr(1, part.size() - 2));
  }
  return pointer;
}

std::string shown(const SortedJson& value) {
  std::string text = value.dump(-1, ' ', true, SortedJson::error_handler_t::replace);
  if (text.size() > kMaxShown) text = text.substr(0, kMaxShown) + "...";
  return text;
}

// The word between the last pair of quotes.
std::string quoted_in(std::string_view text) {
  const std::size_t end = text.rfind('\'');
  const std::size_t begin = end == 0 || end == std::string_view::npos ? std::string_view::npos
                                                                      : text.rfind('\'', end - 1);
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin + 1, end - begin - 1));
}

// "Expected number less than or equal to 255.000000" as "at most 255".
std::string limit_in_words(std::string_view text) {
  const double limit = std::strtod(text.data() + text.rfind(' '), nullptr);
  const bool lower = text.find("greater") != std::string_view::npos;
  const bool included = text.find("equal") != std::string_view::npos;
  return fmt::format(
      "{} {}", lower ? (included ? "at least" : "above") : (included ? "at most" : "below"), limit);
}

std::string in_words(const SchemaError& error, const SortedJson& value) {
  const std::string_view text = error.description;
  if (text.starts_with("Missing required property")) return "lacks the key " + quoted_in(text);
  if (text.starts_with("Object contains a property")) {
    return "has the unknown key " + quoted_in(text);
  }
  if (text.starts_with("Value type not permitted")) {
    return fmt::format("is {}, which has the wrong type", shown(value));
  }
  if (text.starts_with("Failed to match")) {
    return fmt::format("is {}, which is not allowed here", shown(value));
  }
  if (text.starts_with("Expected number")) {
    return fmt::format("is {}; expected {}", shown(value), limit_in_words(text));
  }
  return fmt::format("is {}: {}", shown(value), text);
}

// Valijson treats numbers beyond signed integers as negative.
SortedJson sorted_copy(const Json& value) {
  if (value.is_object()) {
    SortedJson copy = SortedJson::object();
    for (const auto& [key, inner] : value.items()) copy[key] = sorted_copy(inner);
    return copy;
  }
  if (value.is_array()) {
    SortedJson copy = SortedJson::array();
    for (const Json& inner : value) copy.push_back(sorted_copy(inner));
    return copy;
  }
  if (!value.is_number_unsigned()) return value;
  const auto number = value.get<std::uint64_t>();
  return std::min<std::uint64_t>(number, std::numeric_limits<std::int64_t>::max());
}

}  // namespace

struct SchemaCheck::Impl {
  valijson::Schema schema;
  mutable valijson::Validator validator;
};

std::string_view schema_text(std::string_view name) {
  const auto files = schema_files();
  const auto found = std::find_if(files.begin(), files.end(),
                                  [&](const SchemaFile& file) { return file.name == name; });
  ENSONIFY_ASSERT(found != files.end());
  return found->text;
}

SchemaCheck::SchemaCheck(std::string_view name, std::string_view part)
    : impl_(std::make_unique<Impl>()) {
  SortedJson document = SortedJson::parse(schema_text(std::string(name) + ".schema"));
  if (!part.empty()) {
    SortedJson of_part = document.at("definitions").at(std::string(part));
    of_part["definitions"] = std::move(document["definitions"]);
    document = std::move(of_part);
  }
  valijson::SchemaParser parser;
  const Adapter adapter(document);
  parser.populateSchema(adapter, impl_->schema);
}

SchemaCheck::~SchemaCheck() = default;

std::string SchemaCheck::fault(const Json& value, const std::string& at) const {
  const SortedJson sorted = sorted_copy(value);
  const Adapter adapter(sorted);
  if (impl_->validator.validate(impl_->schema, adapter, nullptr)) return {};
  valijson::ValidationResults results;
  impl_->validator.validate(impl_->schema, adapter, &results);
  std::vector<std::string> faults;
  for (const SchemaError& error : results) {
    if (is_consequence(error)) continue;
    const SortedJson::json_pointer pointer = pointer_of(error);
    std::string text =
        fmt::format("#{}{} {}", at, pointer.to_string(), in_words(error, sorted.at(pointer)));
    if (std::find(faults.begin(), faults.end(), text) == faults.end()) {
      faults.push_back(std::move(text));
    }
  }
  if (faults.empty()) return fmt::format("#{} does not match its schema", at);
  if (faults.size() > kMaxFaults) faults.resize(kMaxFaults);
  return fmt::format("{}", fmt::join(faults, "; "));
}

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

std::string cell_fault(const Column& column, std::string_view cell) {
  if (column.type == ColumnType::text) {
    const auto& words = column.words;
    if (words.empty() || std::find(words.begin(), words.end(), cell) != words.end()) return {};
    return fmt::format("is not one of {}", fmt::join(words, ", "));
  }
  if (column.type == ColumnType::integer && !parse_number<std::int64_t>(cell))
    return "is not an integer";
  const auto number = parse_number<double>(cell);
  if (!number) return "is not a number";
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
    return fmt::format("has {}, not {}", counted(cells.size(), "column"), table.size());
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string fault = cell_fault(table[i], cells[i]);
    if (!fault.empty()) return fmt::format("{} `{}` {}", table[i].name, cells[i], fault);
  }
  return {};
}

}  // namespace ensonify
