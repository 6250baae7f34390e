#include "dataset/mask.h"

#include "catch.h"
#include "results.h"

using namespace ensonify;

namespace {

using Box = std::array<std::int64_t, 4>;

}  // namespace

// Protects what `verify` holds areas and boxes against: masks of 7 x 8 written out by hand, with
// runs in one column, over several, from the first pixel and to the last.
TEST_CASE("areas and boxes of run lengths") {
  const auto middle = mask_extent("7340S1", 7, 8);  // 7 3 4 3 39
  REQUIRE(middle);
  CHECK(middle->area == 6);
  CHECK(middle->box == Box{1, 0, 2, 3});
  const auto first = mask_extent("01g1", 7, 8);  // 0 1 55
  REQUIRE(first);
  CHECK(first->area == 1);
  CHECK(first->box == Box{0, 0, 1, 1});
  const auto across = mask_extent("56", 1, 11);  // 5 6 of one row
  REQUIRE(across);
  CHECK(across->box == Box{5, 0, 6, 1});
  const auto over =
      mask_extent("54<", 7, 3);  // 5 4 12: the foot of one column, the head of the next
  REQUIRE(over);
  CHECK(over->area == 4);
  CHECK(over->box == Box{0, 0, 2, 7});
  const auto all = value_of(mask_extent("0f1", 9, 6));
  CHECK(all.area == 54);
  CHECK(all.box == Box{0, 0, 6, 9});
  const auto none = mask_extent("h1", 7, 8);  // 56
  REQUIRE(none);
  CHECK(none->area == 0);
}

// Protects verify against texts that are none of a mask's size, or no code at all.
TEST_CASE("run lengths that are none") {
  for (const char* text : {"", "7340S",
                           "7340S1"
                           "1",
                           "7340R1", "73", " ", "0N", "PPPPPPPPPPPPPPPPPP"}) {
    INFO(text);
    CHECK_FALSE(mask_extent(text, 7, 8));
  }
  CHECK_FALSE(mask_extent("0", 0, 8));
}
