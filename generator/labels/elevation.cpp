#include "labels/elevation.h"

#include <algorithm>
#include <complex>
#include <tuple>

#include "acoustics/propagation.h"
#include "core/error.h"
#include "core/units.h"

namespace ensonify {
namespace {

constexpr std::int64_t kParts = 128;  // of a sample

// The sums of an entry whose delay is not known before all of its echoes are.
struct Sums {
  ElevationEcho echo;
  double diffuse_pa2 = 0;
  std::complex<double> coherent_pa = 0;
  double power = 0, delay = 0;  // the delay times power, in samples from echo.sample
};

bool is_same(const ElevationEcho& a, const ElevationEcho& b) {
  return a.step == b.step && a.instance == b.instance && a.path == b.path;
}

ElevationEcho entry_of(const Sums& sums) {
  ElevationEcho echo = sums.echo;
  echo.offset = static_cast<float>(sums.delay / sums.power);
  echo.diffuse_pa2 = static_cast<float>(sums.diffuse_pa2);
  echo.coherent_pa = std::complex<float>(sums.coherent_pa);
  return echo;
}

auto order_of(const ElevationEcho& echo) {
  return std::tuple(echo.sample, echo.step, echo.offset, echo.instance, echo.path);
}

// The scatterers of one beam cell, which are sorted by delay.
void add_scatterers(const ElevationInput& input, std::size_t beam,
                    std::vector<ElevationEcho>& echoes) {
  const ScattererList& list = input.scatterers;
  const double carrier = carrier_of_beam_hz(input.sonar, static_cast<int>(beam));
  std::vector<Sums> part;  // of one 128th of a sample
  std::int64_t at = 0;
  const auto close = [&] {
    for (const Sums& sums : part) echoes.push_back(entry_of(sums));
    part.clear();
  };
  for (std::uint32_t i = list.beam_offset[beam]; i < list.beam_offset[beam + 1]; ++i) {
    const Scatterer& s = list.items[i];
    const double peak = input.source_pa_m * s.gain, deviation = s.standard_deviation;
    const double diffuse_pa2 = peak * peak * deviation * deviation;
    const std::complex<double> mean_pa = peak * std::complex<double>(s.mean);
    const double power = diffuse_pa2 + std::norm(mean_pa);
    if (!(power > 0)) continue;
    const double delay = s.delay_s * input.sonar.bandwidth_hz;
    const auto now = static_cast<std::int64_t>(std::floor(delay * kParts));
    if (now != at) close();
    at = now;
    ElevationEcho echo;
    // The borders of samples, n - 1/2, are borders of 128ths.
    echo.sample =
        static_cast<std::int32_t>(std::floor((static_cast<double>(now) + kParts / 2) / kParts));
    echo.beam = static_cast<std::uint16_t>(beam);
    echo.step = elevation_step_of(s.arrival.elevation_rad, input.step_rad);
    echo.instance = static_cast<std::uint16_t>(s.instance);
    echo.path = s.path;
    const auto same = std::find_if(part.begin(), part.end(),
                                   [&](const Sums& sums) { return is_same(sums.echo, echo); });
    Sums& sums = same == part.end() ? part.emplace_back(Sums{echo}) : *same;
    sums.diffuse_pa2 += diffuse_pa2;
    sums.coherent_pa += mean_pa * std::polar(1.0, -2 * kPi * carrier_turns(carrier, s.delay_s));
    sums.power += power;
    sums.delay += power * (delay - echo.sample);
  }
  close();
}

}  // namespace

std::vector<ElevationEcho> elevation_echoes(const ElevationInput& input, const Workers& workers) {
  const std::size_t beams = input.scatterers.beam_offset.size() - 1;
  ENSONIFY_ASSERT(input.step_rad > 0 && input.sonar.bandwidth_hz > 0);
  std::vector<std::vector<ElevationEcho>> by_beam(beams);
  workers.for_each(beams, [&](std::size_t beam) {
    std::vector<ElevationEcho>& echoes = by_beam[beam];
    add_scatterers(input, beam, echoes);
    const auto [first, last] =
        std::equal_range(input.volumes.begin(), input.volumes.end(),
                         ElevationEcho{.beam = static_cast<std::uint16_t>(beam)},
                         [](const auto& a, const auto& b) { return a.beam < b.beam; });
    echoes.insert(echoes.end(), first, last);
    std::sort(echoes.begin(), echoes.end(),
              [](const auto& a, const auto& b) { return order_of(a) < order_of(b); });
  });
  std::size_t count = 0;
  for (const auto& echoes : by_beam) count += echoes.size();
  std::vector<ElevationEcho> all;
  all.reserve(count);
  for (auto& echoes : by_beam) {
    all.insert(all.end(), echoes.begin(), echoes.end());
    echoes = {};
  }
  return all;
}

}  // namespace ensonify
