#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::check_single_faults;
using testing::emit;
using testing::kHead;
using testing::parse;

std::string object(const std::string& model) {
  return "materials: {m: {reflectivity: 1}}\n"
         "objects: [{name: a, material: m, shape: {model: " +
         model + "}}]\n";
}

// Protects data sets that are run again: every kind comes back from the resolved text.
TEST_CASE("models are read and written") {
  for (const auto& [word, kind] : kModelKinds) {
    INFO(word);
    const auto first = parse(kHead + object("{kind: " + std::string(word) + ", size_m: 0.35}"));
    REQUIRE(first.ok());
    const auto again = parse(emit(*first));
    REQUIRE(again.ok());
    for (const Scenario* scenario : {&*first, &*again}) {
      const auto* model = std::get_if<ModelSpec>(&scenario->objects[0].shape);
      REQUIRE(model != nullptr);
      CHECK(model->kind == kind);
      CHECK(model->size_m == 0.35);
    }
    CHECK(emit(*first) == emit(*again));
  }
}

TEST_CASE("wrong models are faults at their key") {
  check_single_faults({
      {object("{kind: boot, size_m: 1}"),
       "5:56: objects.0.shape.model.kind:", "one of bottle, can, tyre, chain, hook, propeller"},
      {object("{size_m: 1}"), "5:49: objects.0.shape.model.kind:", "one of bottle"},
      {object("{kind: can}"), "5:49: objects.0.shape.model.size_m:", "a number > 0"},
      {object("{kind: can, size_m: 0}"), "5:69: objects.0.shape.model.size_m:", "a number > 0"},
      {object("{kind: can, size_m: 1, size: 2}"),
       "5:72: objects.0.shape.model.size:", "did you mean size_m?"},
  });
}

}  // namespace
}  // namespace ensonify
