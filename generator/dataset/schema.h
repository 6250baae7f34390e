// JSON against the schemas of output_schema, which are built into the program. Private to dataset/.
//
//   schema_text      the text of a schema or of tables.json
//   SchemaCheck      a schema, or a part of one, made once and used for many values
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "dataset/json.h"

namespace ensonify {

// By the file's name without .json; it must be there.
std::string_view schema_text(std::string_view name);

class SchemaCheck {
 public:
  // `name` as in work.schema.json; `part`: one of its definitions, else the whole.
  explicit SchemaCheck(std::string_view name, std::string_view part = {});
  ~SchemaCheck();
  SchemaCheck(const SchemaCheck&) = delete;
  SchemaCheck& operator=(const SchemaCheck&) = delete;

  // "#/sonar/beams lacks the key count": JSON pointers and what is wrong there, the first few;
  // empty where nothing is. `at` is the pointer of the value itself. Not for several threads at
  // once.
  std::string fault(const Json& value, const std::string& at = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ensonify
