#include "catch.h"
#include "scenario/scenario.h"

using namespace ensonify;

namespace {

const std::string kText =
    "sonar:\n  preset: p\n  receiver: {mode: array, dead: [900]}\nobjects:\n  - {name: a}\n"
    "  - {name: b, material: m}\n";

std::string told(const std::string& message, const std::vector<Override>& overrides = {}) {
  return with_place({ErrorKind::usage, message}, kText, "t.yaml", overrides).message;
}

}  // namespace

// Protects what a user edits next: the line of the key that an error names.
TEST_CASE("an error about a key is told with its place") {
  CHECK(told("sonar.receiver.dead: no 900") == "t.yaml:3:33: sonar.receiver.dead: no 900");
  CHECK(told("objects.1.material: gone") == "t.yaml:6:25: objects.1.material: gone");
  CHECK(with_place({ErrorKind::io, "sonar.preset: x"}, kText, "t.yaml").kind == ErrorKind::io);
}

TEST_CASE("a key that is not there is told by what stands around it") {
  CHECK(told("sonar.receiver.elements: many") == "t.yaml:3:13: sonar.receiver.elements: many");
  CHECK(told("objects.7: x").starts_with("t.yaml:5:3: "));
}

TEST_CASE("an error about no key of the text stays as it is") {
  for (const char* message : {"no such file", "water.profile: x", ": ", "..: "}) {
    CAPTURE(message);
    CHECK(told(message) == message);
  }
  CHECK(told("sonar.receiver.dead: x", {{"sonar.receiver.dead", "[900]"}}) ==
        "sonar.receiver.dead: x");
  CHECK(told("sonar.receiver.dead: x", {{"sonar.receiver", "{dead: [900]}"}}) ==
        "sonar.receiver.dead: x");
  CHECK(with_place({ErrorKind::usage, "a: b"}, "[not a map", "t.yaml").message == "a: b");
}
