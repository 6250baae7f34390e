#include "acoustics/envelope.h"

#include "acoustics/pulse_fixture.h"
#include "catch.h"
#include "core/random.h"

using namespace ensonify;

// Protects the peak that every pulse is scaled by: the transforms behind it against the sum that
// they stand for, for lengths with every radix and with a large prime.
TEST_CASE("the envelope on a grid is the sum over the bins") {
  const std::uint64_t key = stream_key(3, Stream::speckle, 0);
  for (const int count : {2, 6, 8, 16, 30, 64, 90, 94, 120, 250}) {
    std::vector<std::complex<double>> spectrum(count);
    for (int m = 0; m < count; ++m) {
      const ComplexDraw draw = complex_normal(key, count, m, 0);
      spectrum[m] = {draw.re, draw.im};
    }
    for (const int oversampling : {1, 3, 4}) {
      const std::vector<double> squared = envelope_squared(spectrum, oversampling);
      REQUIRE(squared.size() == static_cast<std::size_t>(count * oversampling));
      double worst = 0;
      for (std::size_t k = 0; k < squared.size(); ++k) {
        const double expected =
            std::norm(pulse_at(spectrum, static_cast<double>(k) / oversampling));
        worst = std::max(worst, std::abs(squared[k] - expected));
      }
      INFO(count << " bins, " << oversampling << " instants a sample");
      CHECK(worst < 1e-11 * count);  // of about `count` on average
    }
  }
}
