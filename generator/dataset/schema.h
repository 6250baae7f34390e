// Checks JSON and CSV tables against the schemas of output_schema, which are built into the
// program. Private to dataset/.
//
//   SchemaFile  schema_files   the files of output_schema that verify needs
//   schema_text                the text of a schema or of tables.json
//   SchemaCheck                a schema, or a part of one, made once and used for many values
//   table_schema               of a table, by its file's name
//   header_fault  row_fault    a line against it
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/json.h"

namespace ensonify {

struct SchemaFile {
  const char* name;  // of the file, without .json
  const char* text;
};

// Sorted by name. Defined in a source that scripts/cmake/EmbedFiles.cmake writes.
std::span<const SchemaFile> schema_files();

// The schema with this name, which is the file's name without .json. It must exist.
std::string_view schema_text(std::string_view name);

class SchemaCheck {
 public:
  // `name` as in work.schema.json; `part`: one of its definitions, else the whole.
  explicit SchemaCheck(std::string_view name, std::string_view part = {});
  ~SchemaCheck();
  SchemaCheck(const SchemaCheck&) = delete;
  SchemaCheck& operator=(const SchemaCheck&) = delete;

  // "#/sonar/beams lacks the key count": the first few JSON pointers, each with its error; empty if
  // there is none. `at` is the pointer of the value itself. Not thread-safe.
  std::string fault(const Json& value, const std::string& at = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

enum class ColumnType { integer, number, text };

struct Column {
  std::string name;
  ColumnType type = ColumnType::text;
  std::optional<double> minimum;
  std::vector<std::string> words;  // allowed words; empty: any text
};

using TableSchema = std::vector<Column>;

// None if tables.json does not describe the file.
std::optional<TableSchema> table_schema(std::string_view file_name);

// Returns an empty text if the line is valid, and the error otherwise.
std::string header_fault(const TableSchema& table, std::string_view line);
std::string row_fault(const TableSchema& table, std::string_view line);

}  // namespace ensonify
