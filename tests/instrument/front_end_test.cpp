// Each effect of the electronics against its formula.
#include "instrument/front_end.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "acoustics/pattern.h"
#include "catch.h"
#include "sonar_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

using Samples = std::vector<std::complex<float>>;

struct Receiver {
  explicit Receiver(int beams, double range_m = 10) : sonar(p900(beams, beams * 0.5, range_m)) {
    sonar.front_end.emplace();
    record = make_record(sonar, water, 1e-4);
  }
  FrontEnd& front() { return *sonar.front_end; }
  std::vector<std::uint8_t> run(Samples& p, PingMoment moment = {5, 0, 0, 0}) const {
    return front_end(sonar, water, record, moment, true, p, Workers());
  }
  Samples silence() const { return Samples(std::size_t(sonar.beam_count) * record.samples); }
  double step_m() const { return sample_range_m(sonar, water, 1); }

  Sonar sonar;
  Water water;
  Record record;
};

double pa(double level_db) { return std::pow(10.0, (level_db - 120) / 20); }
bool has(std::uint8_t flags, Artifact artifact) {
  return (flags & static_cast<std::uint8_t>(artifact)) != 0;
}

}  // namespace

TEST_CASE("a receiver without effects changes nothing") {
  Receiver receiver(6);
  Samples p = receiver.silence();
  for (std::size_t i = 0; i < p.size(); ++i) p[i] = {float(i), -1};
  const Samples before = p;
  const auto flags = receiver.run(p);
  CHECK(p == before);
  CHECK(std::all_of(flags.begin(), flags.end(), [](auto f) { return f == 0; }));
}

TEST_CASE("each beam has its response, and leaks into its neighbors alone") {
  Receiver receiver(5);
  receiver.front().beam_response = {1, {0, 2}, 3, 1, 1};
  receiver.front().crosstalk_db = {{-20}};
  Samples p = receiver.silence();
  const int samples = receiver.record.samples;
  p[1 * samples + 7] = 4;
  receiver.run(p);
  const auto at = [&](int beam) { return p[std::size_t(beam) * samples + 7]; };
  CHECK(std::abs(at(1) - std::complex<float>(0, 8)) < 1e-5f);
  CHECK(std::abs(at(0) - std::complex<float>(0, 0.8f)) < 1e-5f);
  CHECK(std::abs(at(2) - std::complex<float>(0, 0.8f)) < 1e-5f);
  CHECK(at(3) == 0.0f);
}

// With groups that transmit in turn, number k of the list applies to the beams k groups away.
TEST_CASE("a list of cross-talk gives a comb of its levels") {
  const int groups = GENERATE(1, 4);
  Receiver receiver(21);
  receiver.sonar.transmit = TransmitGroups{.count = groups};
  receiver.front().crosstalk_db = {{-4.9, -6.8}};
  Samples p = receiver.silence();
  const int samples = receiver.record.samples;
  p[9 * samples + 7] = {0, 2};
  receiver.run(p);
  for (int beam = 0; beam < 21; ++beam) {
    const int away = std::abs(beam - 9);
    double share = away == 0 ? 1 : 0;
    if (away == groups) share = std::pow(10.0, -4.9 / 20);
    if (away == 2 * groups) share = std::pow(10.0, -6.8 / 20);
    CAPTURE(groups, beam);
    CHECK(std::abs(p[std::size_t(beam) * samples + 7] -
                   std::complex<float>(0, static_cast<float>(2 * share))) < 1e-6f);
  }
}

TEST_CASE("the share of the gain error that varies is sampled anew in each ping") {
  constexpr int kBeams = 3000;
  Receiver receiver(kBeams, 0.5);
  receiver.sonar.beam_spacing_rad = 1e-4;
  receiver.front().beam_response.assign(kBeams, {0, 2});
  receiver.front().ping_gain_error_db = 1.5;
  std::vector<double> gains_db[2];
  for (std::uint32_t ping = 0; ping < 2; ++ping) {
    Samples p = receiver.silence();
    for (std::complex<float>& value : p) value = 1;
    receiver.run(p, {5, 0, ping, 0});
    for (int beam = 0; beam < kBeams; ++beam) {
      const std::complex<float> heard = p[std::size_t(beam) * receiver.record.samples];
      CHECK(std::abs(heard.real()) < 1e-6f);  // the phase stays
      gains_db[ping].push_back(20 * std::log10(std::abs(heard) / 2));
    }
  }
  double first = 0, second = 0, both = 0;
  for (int beam = 0; beam < kBeams; ++beam) {
    first += std::pow(gains_db[0][beam], 2);
    second += std::pow(gains_db[1][beam], 2);
    both += gains_db[0][beam] * gains_db[1][beam];
  }
  // Standard errors: 1.3 % of the deviation, 0.018 of the correlation.
  CHECK(std::sqrt(first / kBeams) == Approx(1.5).epsilon(0.05));
  CHECK(std::sqrt(second / kBeams) == Approx(1.5).epsilon(0.05));
  CHECK(std::abs(both) / std::sqrt(first * second) < 0.06);
}

TEST_CASE("the level of a group varies from ping to ping and from group to group") {
  Receiver receiver(16);
  receiver.sonar.transmit = TransmitGroups{.count = 8};
  CHECK(group_levels_db(receiver.sonar, {5, 0, 0, 0}).empty());
  const std::vector<double> fixed = {-0.5, 0, 0.2, 1, -1, 0.3, 0, 0};
  receiver.sonar.transmit->level_db = fixed;
  CHECK(group_levels_db(receiver.sonar, {5, 3, 7, 0}) == fixed);
  receiver.sonar.transmit->level_error_db = 0.8;
  double square = 0, pings = 0, groups = 0;
  std::vector<double> before(8);
  for (std::uint32_t ping = 0; ping < 1000; ++ping) {
    std::vector<double> levels = group_levels_db(receiver.sonar, {5, 3, ping, 0});
    REQUIRE(levels.size() == 8);
    std::ranges::transform(levels, fixed, levels.begin(), std::minus{});
    for (int g = 0; g < 8; ++g) {
      square += levels[g] * levels[g];
      pings += levels[g] * before[g];
      groups += levels[g] * levels[(g + 1) % 8];
    }
    before = levels;
  }
  // Of 8000 numbers: standard errors 0.8 % of the deviation, 0.011 of the correlations.
  CHECK(std::sqrt(square / 8000) == Approx(0.8).epsilon(0.03));
  CHECK(std::abs(pings / square) < 0.04);
  CHECK(std::abs(groups / square) < 0.04);
}

TEST_CASE("errors of beams have their standard deviations and depend on the seed alone") {
  constexpr int kBeams = 4000;
  const auto responses = beam_responses(9, kBeams, 1.5, 0.2);
  double gain = 0, phase = 0;
  for (const auto& r : responses) {
    gain += std::pow(20 * std::log10(std::abs(r)), 2);
    phase += std::pow(std::arg(r), 2);
  }
  // Standard error of a standard deviation: sigma/sqrt(2 n), 1.1 %.
  CHECK(std::sqrt(gain / kBeams) == Approx(1.5).epsilon(0.045));
  CHECK(std::sqrt(phase / kBeams) == Approx(0.2).epsilon(0.045));
  CHECK(beam_responses(9, kBeams, 1.5, 0.2) == responses);
  CHECK(beam_responses(10, kBeams, 1.5, 0.2) != responses);
}

TEST_CASE("leakage falls exponentially and is the same in every ping") {
  Receiver receiver(3000, 3);
  receiver.front().leakage = {150, 0.3};
  Samples p = receiver.silence(), again = receiver.silence();
  const auto flags = receiver.run(p);
  receiver.run(again, {5, 4, 8, 2.5});
  CHECK(p == again);
  CHECK(has(flags[0], Artifact::leakage));
  for (const int n : {0, 10, 40}) {
    double power = 0;
    for (int beam = 0; beam < 3000; ++beam) {
      power += std::norm(p[std::size_t(beam) * receiver.record.samples + n]);
    }
    const double expected = std::pow(pa(150) * std::exp(-n * receiver.step_m() / 0.3), 2);
    CHECK(power / 3000 == Approx(expected).epsilon(4 / std::sqrt(3000.0)));
  }
}

TEST_CASE("bursts of another sonar come at its ping rate, weighted by the beam pattern") {
  Receiver receiver(41, 20);
  const double azimuth_rad = beam_azimuth_rad(receiver.sonar, 25);
  receiver.front().interference = {140, 80, 1e-3, azimuth_rad};
  const double dt = receiver.record.sample_interval_s;
  std::vector<double> middles;
  for (std::uint32_t ping = 0; ping < 3; ++ping) {
    const double time_s = 0.31 * ping;
    Samples p = receiver.silence();
    const auto flags = receiver.run(p, {5, 0, ping, time_s});
    const auto beam = [&](int j) { return p.data() + std::size_t(j) * receiver.record.samples; };
    int strongest = 0;
    for (int n = 0; n < receiver.record.samples; ++n) {
      if (std::abs(beam(25)[n]) > std::abs(beam(25)[strongest])) strongest = n;
      CHECK(has(flags[std::size_t(n) * 41 + 25], Artifact::interference) ==
            (std::abs(beam(25)[n]) > 0));
    }
    // One of at least two bursts of 30 samples has a sample within half a step of its middle.
    CHECK(std::abs(beam(25)[strongest]) == Approx(pa(140)).epsilon(0.005));
    middles.push_back(time_s + strongest * dt);
    for (const int j : {24, 27, 40}) {
      const double off_rad = beam_azimuth_rad(receiver.sonar, j) - azimuth_rad;
      const double weight = line_pattern(off_rad, receiver.sonar.beam_width_rad);
      const double ratio = std::abs(beam(j)[strongest]) / double(std::abs(beam(25)[strongest]));
      CHECK(ratio == Approx(std::abs(weight)).margin(1e-5));
    }
  }
  for (const double middle : middles) {
    const double periods = (middle - middles[0]) * 80;
    CHECK(std::abs(periods - std::round(periods)) < 80 * dt);
  }
}

// Protects times before 0, which trajectories may have.
TEST_CASE("bursts come before time 0 too") {
  Receiver receiver(3, 20);
  receiver.front().interference = {140, 80, 1e-3, 0};
  for (const double time_s : {-1e6, -0.3, 1e6}) {
    Samples p = receiver.silence();
    const auto flags = receiver.run(p, {5, 0, 0, time_s});
    const auto marked = std::count_if(flags.begin(), flags.end(), [](auto f) { return f != 0; });
    // 2.1 bursts of 30 samples in each beam, in a record of 26.7 ms.
    CHECK(marked > 3 * 29);
    CHECK(marked < 3 * 31 * 3);
  }
}

TEST_CASE("a saturated receiver clips, and a tail follows that falls by e over its length") {
  Receiver receiver(4000, 8);
  receiver.front().saturation = {130, -20, 1.5};
  const int samples = receiver.record.samples;
  Samples p = receiver.silence();
  for (int beam = 0; beam < 4000; beam += 2) {
    p[std::size_t(beam) * samples + 20] = float(5 * pa(130));
  }
  const auto flags = receiver.run(p);
  CHECK(std::abs(p[20]) == Approx(pa(130)));
  CHECK(has(flags[20 * 4000], Artifact::clipped));
  CHECK(flags[20 * 4000 + 1] == 0);
  CHECK(p[19] == 0.0f);
  for (const int behind : {1, 30, 90}) {
    double power = 0;
    for (int beam = 0; beam < 4000; beam += 2) {
      power += std::norm(p[std::size_t(beam) * samples + 20 + behind]);
    }
    CHECK(p[samples + 20 + behind] == 0.0f);
    CHECK(has(flags[std::size_t(20 + behind) * 4000], Artifact::streak));
    const double expected = 0.1 * 4 * pa(130) * std::exp(-(behind - 1) * receiver.step_m() / 1.5);
    CHECK(power / 2000 == Approx(expected * expected).epsilon(4 / std::sqrt(2000.0)));
  }
}

TEST_CASE("the limit alone leaves no tail") {
  Receiver receiver(1);
  receiver.front().saturation = {130, {}, 1};
  Samples p = receiver.silence();
  p[20] = {0, float(-3 * pa(130))};
  receiver.run(p);
  CHECK(std::abs(p[20] - std::complex<float>(0, float(-pa(130)))) < 1e-5f);
  CHECK(p[21] == 0.0f);
}

TEST_CASE("a blanked receiver hears nothing, not even its own pulse") {
  Receiver receiver(2);
  receiver.front().leakage = {170, 1};
  receiver.front().blanking_m = 2;
  Samples p = receiver.silence();
  const auto flags = receiver.run(p);
  for (int n = 0; n < receiver.record.samples; ++n) {
    const bool off = n * receiver.step_m() < 2;
    CHECK((p[n] == 0.0f) == off);
    CHECK(has(flags[2 * n], Artifact::blanked) == off);
    CHECK(has(flags[2 * n], Artifact::leakage) == !off);
  }
}
