// JSON Schema for tests, without valijson's headers in each of them.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace ensonify::test {

class JsonSchema {
 public:
  explicit JsonSchema(const nlohmann::json& schema);
  ~JsonSchema();

  bool accepts(const nlohmann::json& value) const;
  // The place and the description of each error, one a line; empty where there is none.
  std::string fault(const nlohmann::json& value) const;

 private:
  struct Checked;
  std::unique_ptr<Checked> checked_;
};

}  // namespace ensonify::test
