// output_schema/scenario.schema.json beside the parser, for tests.
//
//   schema                    the whole of it
//   map_schema  list_schema   what a use of it says of a map, of a list; null: none stands there
//   schema_accepts            whether a scenario is as the schema says
//   schema_fault              why it is not; empty: it is
//   json_of                   a tree of the reader as JSON
//   docs_blocks               fenced blocks of docs/scenario.md
//   Samples                   scenarios that between them have every map, with the files they name
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scenario/yaml_tree.h"
#include "temporary_folder.h"

namespace ensonify::testing {

using Json = nlohmann::json;

const Json& schema();
const Json* map_schema(const Json& use);
const Json* list_schema(const Json& use);

bool schema_accepts(const Json& scenario);
std::string schema_fault(const Json& scenario);
Json json_of(const Node& node);
Json json_of(const std::string& yaml);

std::vector<std::string> docs_blocks(const std::string& language);

class Samples {
 public:
  Samples();
  const std::vector<std::string>& texts() const { return texts_; }
  const std::filesystem::path& folder() const { return folder_.path(); }

 private:
  test::TemporaryFolder folder_;
  std::vector<std::string> texts_;
};

}  // namespace ensonify::testing
