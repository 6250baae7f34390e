#include <filesystem>
#include <fstream>
#include <set>

#include "results.h"
#include "sweeps.h"

namespace ensonify {
namespace {

using testing::faults_of;

std::vector<std::string> page(const std::string& name = "sweeps.md") {
  std::ifstream file(std::string(ENSONIFY_DOCS) + "/" + name);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> section(const std::string& name, const std::string& heading) {
  std::vector<std::string> lines;
  bool inside = false;
  for (const std::string& line : page(name)) {
    if (line.starts_with("## ")) inside = line == "## " + heading;
    if (inside) lines.push_back(line);
  }
  return lines;
}

// First words in back quotes of the table's rows under a heading.
std::set<std::string> documented(const std::string& heading,
                                 const std::string& name = "sweeps.md") {
  std::set<std::string> keys;
  for (const std::string& line : section(name, heading)) {
    if (line.starts_with("| `")) keys.insert(line.substr(3, line.find('`', 3) - 3));
  }
  return keys;
}

// The values after "expected one of " in an error.
std::set<std::string> accepted(const std::string& fault) {
  std::set<std::string> keys;
  const std::string mark = "expected one of ";
  std::string rest = fault.substr(fault.find(mark) + mark.size()) + ", ";
  for (std::size_t end = rest.find(", "); end != std::string::npos; end = rest.find(", ")) {
    keys.insert(rest.substr(0, end));
    rest.erase(0, end + 2);
  }
  return keys;
}

// Protects the page from keys that are gone, and keys from being left out of it.
TEST_CASE("the page has the keys of the parser and no other") {
  const testing::SweepFolder folder;
  const auto head = faults_of(folder.parse("seeds: 1\nqqqqqqqqqqqq: 1\n"));
  REQUIRE(head.size() == 1);
  CHECK(documented("Keys") == accepted(head[0]));
  const auto axis = faults_of(folder.parse("axes: [{key: a.b, values: [1], qqqqqqqqqqqq: 1}]\n"));
  REQUIRE(axis.size() == 1);
  CHECK(documented("Axes") == accepted(axis[0]));
}

// Protects the list of members of a plan, and the sentence on the page of sweeps that names them.
TEST_CASE("the page has the members of a plan and no other") {
  const std::string line = to_jsonl({{"0123456789abcdef", "", {}, 0, 1, 0}});
  std::set<std::string> members;
  for (std::size_t at = line.find("\":"); at != std::string::npos; at = line.find("\":", at + 1)) {
    const std::size_t open = line.rfind('"', at - 1);
    members.insert(line.substr(open + 1, at - open - 1));
  }
  CHECK(documented("plan.jsonl", "file_members.md") == members);
  const std::string text = joined_lines(section("sweeps.md", "The plan"));
  for (const std::string& member : members) {
    INFO(member);
    CHECK(contains(text, "`" + member + "`"));
  }
}

// Protects whoever copies from the page.
TEST_CASE("every example of the page expands") {
  std::string example;
  std::size_t count = 0;
  bool inside = false;
  for (const std::string& line : page()) {
    if (line == "```yaml") {
      inside = true;
      example.clear();
    } else if (line == "```" && inside) {
      inside = false;
      ++count;
      auto file = value_of(parse_sweep_file(example, "example.yaml",
                                            std::filesystem::path(ENSONIFY_DOCS).parent_path()));
      const auto sweep = value_of(expand_sweep(std::move(file), testing::plain_cost, Workers(2)));
      CHECK(sweep.runs.size() > 10);
      CHECK(sweep.left_out > 0);
    } else if (inside) {
      example += line + "\n";
    }
  }
  CHECK(count == 1);
}

}  // namespace
}  // namespace ensonify
