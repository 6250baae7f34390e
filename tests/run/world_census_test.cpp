// What `check` says of the worlds that it builds.
#include "run/world_census.h"

#include "catch.h"

using namespace ensonify;

// Protects honest lines: of a sample there is a bound, of all sequences there is none to state.
TEST_CASE("the lines of a census say how sure they are") {
  WorldCensus census{4000, 200, {}, {}};
  CHECK(census_lines(census) ==
        std::vector<std::string>{"worlds built: 200 of 4000; impossible: 0 (0 %, at most 1.5 % "
                                 "with 95 % confidence)"});
  census.sequences = 200;
  census.placement = {200, 10, 14, 0, {{"ball", 600, 500}}};
  CHECK(census_lines(census) ==
        std::vector<std::string>{
            "worlds built: 200 of 200; impossible: 0 (0 %)",
            "worlds sampled again for lack of room: 10 (5 %), 14 redraws in total",
            "objects per sequence, kept of first sampled: ball 2.50 of 3.00"});
  CHECK(census_lines({}).empty());
}
