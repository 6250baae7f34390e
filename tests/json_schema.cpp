#include "json_schema.h"

#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

namespace ensonify::test {

using Adapter = valijson::adapters::NlohmannJsonAdapter;

struct JsonSchema::Checked {
  valijson::Schema schema;
};

JsonSchema::JsonSchema(const nlohmann::json& schema) : checked_(std::make_unique<Checked>()) {
  valijson::SchemaParser().populateSchema(Adapter(schema), checked_->schema);
}

JsonSchema::~JsonSchema() = default;

bool JsonSchema::accepts(const nlohmann::json& value) const {
  return valijson::Validator().validate(checked_->schema, Adapter(value), nullptr);
}

std::string JsonSchema::fault(const nlohmann::json& value) const {
  valijson::ValidationResults results;
  if (valijson::Validator().validate(checked_->schema, Adapter(value), &results)) return {};
  std::string text;
  for (const auto& error : results) {
    for (const std::string& part : error.context) text += part;
    text += ": " + error.description + "\n";
  }
  return text;
}

}  // namespace ensonify::test
