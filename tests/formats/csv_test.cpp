#include "formats/csv.h"

#include <array>

#include "catch.h"

using namespace ensonify;

// Protects readers of a data set's tables: a row is read whole or not at all.
TEST_CASE("a row of numbers has as many as are wanted, and nothing else") {
  std::array<double, 3> values{};
  REQUIRE(read_numbers("1,-2.5,3e4", values));
  CHECK(values == std::array<double, 3>{1, -2.5, 3e4});
  for (const char* wrong : {"", "1,2", "1,2,3,4", "1,2,3,", "1,,3", "1,2,x", "1,2,3x", "1, 2,3"}) {
    INFO(wrong);
    CHECK_FALSE(read_numbers(wrong, values));
  }
  CHECK(columns_of("", ',').size() == 1);
  CHECK(columns_of("a,,b,", ',') == std::vector<std::string_view>{"a", "", "b", ""});
}

// Protects names with commas, quotes or line ends in a table.
TEST_CASE("a text is quoted in a table where it has to be") {
  CHECK(csv_cell("plain text") == "plain text");
  CHECK(csv_cell("a,b") == "\"a,b\"");
  CHECK(csv_cell("a \"b\"\n") == "\"a \"\"b\"\"\n\"");
}

// Protects the report over runs, which reads the table of a sweep: every cell comes back as it was.
TEST_CASE("the cells of a table read back") {
  const std::vector<std::vector<std::string>> table = {
      {"run", "a,b", "say \"x\""}, {"", "two\nlines", "\""}, {"1", "", ""}, {""}};
  std::string text;
  for (const auto& row : table) {
    for (std::size_t k = 0; k < row.size(); ++k) text += (k > 0 ? "," : "") + csv_cell(row[k]);
    text += "\n";
  }
  CHECK(csv_rows(text) == table);
  CHECK(csv_rows("a,b") == std::vector<std::vector<std::string>>{{"a", "b"}});
  CHECK(csv_rows("").empty());
}
