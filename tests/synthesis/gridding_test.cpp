#include "synthesis/cpu/gridding.h"

#include <cmath>

#include "catch.h"
#include "core/random.h"

using namespace ensonify;

// Protects the deposit: the kernel's stated error, and samples whose kernel wraps around the
// period's ends.
TEST_CASE("spreading gives the sums of phasors") {
  const int highest = 45, grid = 180, count = 60;
  const GriddingKernel kernel = make_gridding_kernel(grid, highest);
  std::vector<std::complex<double>> fine(grid);
  std::vector<double> x(count);
  std::vector<std::complex<double>> value(count);
  for (int i = 0; i < count; ++i) {
    x[i] = i < 4 ? (i - 2) * 1e-3 + (i == 3 ? 0.998 : 0) : uniform(8, 0, i, 0);
    value[i] = {uniform(8, 0, i, 1) - 0.5, uniform(8, 0, i, 2) - 0.5};
    spread(kernel, x[i], value[i], fine.data());
  }
  for (int k = -highest; k <= highest; ++k) {
    std::complex<double> exact = 0, obtained = 0;
    for (int i = 0; i < count; ++i) exact += value[i] * std::polar(1.0, -2 * kPi * k * x[i]);
    for (int l = 0; l < grid; ++l) {
      obtained += fine[l] * std::polar(1.0, -2 * kPi * k * l / grid);
    }
    obtained *= kernel.correction[std::abs(k)];
    CHECK(std::abs(obtained - exact) < 1e-14 * count);
  }
}
