#include "synthesis/cuda/doppler_tables.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/error.h"
#include "synthesis/cpu/doppler_synthesis.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// A burst's shifted spectrum may be all at the band's edge, where the kernel is up to five times
// worse than over a flat one.
constexpr double kFlatError = 1e-6;
// Above: the mean enters the expected power as a square. Below: single precision.
constexpr double kMostTolerance = 3e-5, kLeastTolerance = 5e-6;
// Band b of rising shifts is b + 1, of falling ones -b - 1.
std::set<int> bands_of(const DopplerNodes& nodes, std::span<const ShiftRecord> shifts) {
  std::set<int> bands;
  int latest = 0;
  for (const ShiftRecord& s : shifts) {
    const double doppler = s.doppler;
    const int above = 1 + static_cast<int>(std::abs(doppler) / nodes.width);
    const int band = doppler < 0 ? -above : above;
    if (band != latest) bands.insert(band);
    latest = band;
  }
  return bands;
}

}  // namespace

DopplerTables make_doppler_tables(const SynthesisSetup& setup) {
  const int bins = setup.record.transform;
  DopplerTables tables;
  tables.pulse = make_doppler_pulse(setup.sonar, bins);
  tables.nodes = choose_doppler_nodes(tables.pulse,
                                      std::clamp(setup.tolerance, kLeastTolerance, kMostTolerance));
  ENSONIFY_ASSERT(tables.nodes.degree > 0);
  for (int q = 0; q <= tables.nodes.degree; ++q) {
    tables.place.push_back(node_doppler(tables.nodes, q) / tables.nodes.width);
  }
  tables.spread = series_spread(std::vector<Complex>(bins, 1), kFlatError);
  tables.loudest = largest_magnitude(doppler_spectrum(tables.pulse, 0));
  return tables;
}

std::vector<Complex32> node_filter(const DopplerTables& tables, int node) {
  const std::vector<Complex> spectrum =
      doppler_spectrum(tables.pulse, node_doppler(tables.nodes, node));
  if (largest_magnitude(spectrum) <= kInaudible * tables.loudest) return {};
  const int bins = static_cast<int>(spectrum.size()), half = bins / 2;
  std::vector<Complex32> filter(bins);
  for (int m = 0; m < bins; ++m) {
    const int bin = m < half ? m + half : m - half;
    const Complex s = spectrum[m] * static_cast<double>(tables.spread.filter[bin].re);
    filter[bin] = {static_cast<float>(s.real()), static_cast<float>(s.imag())};
  }
  return filter;
}

NodesInUse nodes_in_use(const DopplerNodes& nodes, const PingBatch& batch, const Workers& workers) {
  const std::size_t pings = batch.pings.size();
  std::vector<std::set<int>> bands(pings);
  workers.for_each(pings, [&](std::size_t p) {
    const std::uint32_t* at = batch.shift_offset.data() + batch.pings[p].first_offset;
    const std::size_t sectors = batch.shift_offset.size() / pings - 1;
    const std::span<const ShiftRecord> all = batch.shifts;
    bands[p] = bands_of(nodes, all.subspan(at[0], at[sectors] - at[0]));
  });
  std::map<int, std::vector<unsigned char>> uses;
  for (std::size_t p = 0; p < pings; ++p) {
    for (const int band : bands[p]) {
      const int step = band < 0 ? -1 : 1, first = (std::abs(band) - 1) * nodes.degree;
      for (int q = 0; q <= nodes.degree; ++q) {
        if (first + q == 0) continue;
        auto& pings_of = uses[step * (first + q)];
        pings_of.resize(pings);
        pings_of[p] = 1;
      }
    }
  }
  NodesInUse used;
  for (const auto& [node, pings_of] : uses) {
    used.node.push_back(node);
    used.uses.insert(used.uses.end(), pings_of.begin(), pings_of.end());
  }
  return used;
}

}  // namespace ensonify
