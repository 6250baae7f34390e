#include "app/progress.h"

#include "catch.h"

using namespace ensonify;

TEST_CASE("progress tells pings, rate and time left") {
  CHECK(progress_text(0, 40, 0, 0) == "0/40 pings");
  CHECK(progress_text(12, 40, 10, 5) == "12/40 pings, 2 pings/s, 14 s left");
  CHECK(progress_text(100, 10100, 100, 50) == "100/10100 pings, 2 pings/s, 1 h 23 min left");
  CHECK(progress_text(40, 40, 40, 10) == "40/40 pings, 4 pings/s");
}
