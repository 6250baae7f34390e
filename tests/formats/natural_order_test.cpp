#include "formats/natural_order.h"

#include "catch.h"

using namespace ensonify;

// Protects the order of pings in folders whose names are not filled up with zeros.
TEST_CASE("numbers in names are ordered as numbers") {
  std::vector<std::string> names = {"a10.png",
                                    "a9.png",
                                    "b1",
                                    "a2_10",
                                    "a2_9",
                                    "10",
                                    "9",
                                    "a01.png",
                                    "a1.png",
                                    "a1",
                                    "a",
                                    "007",
                                    "7",
                                    "08",
                                    "a99999999999999999999999",
                                    "a100000000000000000000000"};
  sort_naturally(names);
  CHECK(names == std::vector<std::string>{"7", "007", "08", "9", "10", "a", "a1", "a1.png",
                                          "a01.png", "a2_9", "a2_10", "a9.png", "a10.png",
                                          "a99999999999999999999999", "a100000000000000000000000",
                                          "b1"});
}

// Protects std::sort, which needs a strict order.
TEST_CASE("the order of names is strict") {
  const std::vector<std::string> names = {"",    "0",    "00", "a0", "a00",
                                          "a0b", "a00a", "1",  "01", "a"};
  for (const std::string& a : names) {
    CHECK_FALSE(natural_less(a, a));
    for (const std::string& b : names) {
      INFO(a << " " << b);
      if (a != b) CHECK(natural_less(a, b) != natural_less(b, a));
      for (const std::string& c : names) {
        if (natural_less(a, b) && natural_less(b, c)) CHECK(natural_less(a, c));
      }
    }
  }
}
