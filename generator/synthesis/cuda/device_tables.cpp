#include "synthesis/cuda/device_tables.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "acoustics/pulse.h"
#include "core/error.h"
#include "core/units.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/array_nodes.h"
#include "synthesis/cpu/array_records.h"
#include "synthesis/cpu/node_sums.h"
#include "synthesis/cuda/beam_kernels.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// Single precision has errors of 1e-6 in any case.
constexpr double kPowerError = 1e-6;
// The error of beams from nodes. With the kernel's 3e-6 it is half of the 1e-5 that records may
// differ by.
constexpr double kNodeError = 2e-6;

DeviceSpread power_spread(const std::vector<Complex>& autospectrum) {
  const int bins = static_cast<int>(autospectrum.size());
  const SpreadKernel kernel = choose_spread_kernel(autospectrum, 0, kPowerError);
  DeviceSpread spread = spread_of(kernel, bins);
  for (int k = 0; k < bins; ++k) {
    const Complex upper = k > 0 ? std::conj(autospectrum[bins - k]) : Complex(0);
    spread.filter[k] = narrow(autospectrum[k] * kernel.correction[k]);
    if (k > 0) spread.upper_filter[k] = narrow(upper * kernel.correction[bins - k]);
    spread.cell_filter[k] = narrow(autospectrum[k] + upper);
  }
  return spread;
}

// The error of an array's records. Half of it is left to single precision.
constexpr double kArrayError = 1e-5;

// The error of the kernel for a flat spectrum. With Doppler, the spectrum of a burst may be close
// to the edge of the band, where the error is up to five times as large.
constexpr double kFlatError = 1e-6;
// The largest value is due to the expected power, which has the square of the mean. The smallest is
// due to single precision.
constexpr double kMostTolerance = 3e-5, kLeastTolerance = 5e-6;
// The bands in use: b + 1 for band b of positive Doppler, -b - 1 for band b of negative Doppler.
std::set<int> bands_of(const DopplerNodes& nodes, std::span<const DopplerRecord> shifts) {
  std::set<int> bands;
  int latest = 0;
  for (const DopplerRecord& s : shifts) {
    const double doppler = s.doppler;
    const int above = 1 + static_cast<int>(std::abs(doppler) / nodes.width);
    const int band = doppler < 0 ? -above : above;
    if (band != latest) bands.insert(band);
    latest = band;
  }
  return bands;
}

std::vector<double> beam_cosines(const Sonar& sonar) {
  std::vector<double> cosines;
  for (const double azimuth : beam_azimuths_rad(sonar)) cosines.push_back(std::sin(azimuth));
  return cosines;
}

SynthesisSetup array_setup(SynthesisSetup setup) {
  setup.tolerance = kArrayError;
  return setup;
}

// A warp of a device sums the moments of one group.
constexpr int kMostGroupElements = 32;

DeviceGroups groups_of(const SpreadKernel& spread, const GroupKernel& kernel, int elements,
                       double exact_range_m) {
  DeviceGroups groups{
      spread.points, spread.width, kernel.terms, elements, kernel.per_reach, exact_range_m, {}};
  const int powers = 2 * kernel.terms;
  groups.weight.resize(std::size_t(spread.width + kPointsAThread - 1) * powers);
  for (int d = 0; d < spread.width + kPointsAThread - 1; ++d) {
    for (int k = 0; k < powers; ++k) {
      for (int j = 0; j < kPointsAThread; ++j) {
        const int tap = j + spread.width - 1 - d;
        if (tap < 0 || tap >= spread.width) continue;
        const int pair = std::min(tap, spread.width - 1 - tap), odd = k % 2;
        const float c =
            kernel.coefficient[(pair * kernel.terms + kernel.terms - 1 - k / 2) * 2 + odd];
        groups.weight[std::size_t(d) * powers + k].of_point[j] = tap != pair && odd == 1 ? -c : c;
      }
    }
  }
  return groups;
}

void fill_taps(const SynthesisSetup& setup, BeamTaps taps, ArrayTables& tables) {
  const int period = 2 * setup.record.transform;
  for (const double c : taps.correction) tables.correction.push_back(static_cast<float>(c));
  for (const std::int32_t at : taps.begin) {
    tables.begin.push_back((at % period + period) % period);
  }
  tables.tap.resize(taps.begin.size());
  for (std::size_t i = 0; i < taps.tap.size(); ++i) {
    tables.tap[i / kElementTaps].of_tap[i % kElementTaps] = taps.tap[i];
  }
}

void add_stretch(const NodeStretch& stretch, ArrayNodeTables& tables) {
  constexpr int kMost = kSamplesAThread * kGridLanes;
  const auto number = static_cast<std::int32_t>(tables.first.size() / stretch.first.size());
  const auto begin = static_cast<std::int64_t>(tables.coefficient.size());
  for (int n = stretch.begin; n < stretch.end; n += kMost) {
    tables.pieces.push_back({begin, number, n, std::min(kMost, stretch.end - n), stretch.orders,
                             stretch.taps, stretch.degree});
  }
  for (std::size_t i = 0; i < stretch.coefficient.size(); i += 2) {
    tables.coefficient.push_back({stretch.coefficient[i], stretch.coefficient[i + 1]});
  }
  tables.first.insert(tables.first.end(), stretch.first.begin(), stretch.first.end());
  for (int n = stretch.begin; stretch.degree > 0 && n < stretch.end; ++n) {
    tables.time[n] = static_cast<float>(stretch.time(n));
  }
}

ArrayNodeTables node_tables(const ArrayPlan& plan) {
  ArrayNodeTables tables;
  tables.near_samples = plan.samples();
  const auto nodes = make_array_nodes(plan);
  if (!nodes) return tables;
  tables.count = nodes->count;
  tables.orders = nodes->orders;
  tables.near_samples = nodes->near_samples;
  tables.grid = nodes->grid;
  tables.first_row = nodes->first_row;
  tables.block_bins = nodes->block_bins;
  tables.blocks = static_cast<int>(nodes->blocks.size());
  tables.element_weight.resize(plan.elements());
  for (std::size_t i = 0; i < nodes->element_weight.size(); ++i) {
    tables.element_weight[i / 4].power[i % 4] = static_cast<float>(nodes->element_weight[i]);
  }
  for (const Complex& phase : nodes->row_phase) tables.row_phase.push_back(narrow(phase));
  tables.base.assign(nodes->base.begin(), nodes->base.end());
  const double* weight = nodes->weight.data();
  tables.steer_weight.assign(weight, weight + nodes->weight.size());
  tables.time.resize(plan.samples());
  for (const NodeStretch& stretch : nodes->stretches) add_stretch(stretch, tables);
  return tables;
}

// The weights of nodes in beams, [beams][nodes]: P K with the scales, or R.
std::vector<double> weights_of_nodes(const BeamNodes& nodes, const std::vector<double>& scale) {
  if (!nodes.is_equal) return nodes.matrix;
  std::vector<double> weights(std::size_t(nodes.beams) * nodes.nodes);
  for (int j = 0; j < nodes.beams; ++j) {
    for (int a = 0; a < nodes.width; ++a) {
      const double p = scale[j] * nodes.weight[std::size_t(j) * nodes.width + a];
      const double* row = nodes.matrix.data() + std::size_t(nodes.first[j] + a) * nodes.nodes;
      double* to = weights.data() + std::size_t(j) * nodes.nodes;
      for (int c = 0; c < nodes.nodes; ++c) to[c] += p * row[c];
    }
  }
  return weights;
}

DeviceMixing mixing_by_nodes(const Mixing& mixing, bool squared) {
  const BeamNodes nodes = nodes_of(mixing, squared, kNodeError, mixing.beams());
  std::vector<double> scale;
  for (const double s : mixing.scale) scale.push_back(squared ? s * s : s);
  DeviceMixing result;
  result.nodes = nodes.nodes;
  for (int row = 0; row < nodes.nodes / 2; ++row) {
    result.row_offset.push_back(static_cast<std::uint32_t>(result.cells.size()));
    for (int j = 0; j < nodes.beams; ++j) {
      const auto weight_at = [&](int node) {
        const int a = node - nodes.first[j];
        if (a < 0 || a >= nodes.width) return 0.0f;
        return static_cast<float>(nodes.weight[std::size_t(j) * nodes.width + a]);
      };
      const float even = weight_at(2 * row), odd = weight_at(2 * row + 1);
      if (even == 0 && odd == 0) continue;
      result.cells.push_back({static_cast<std::uint32_t>(j), even, odd});
    }
  }
  result.row_offset.push_back(static_cast<std::uint32_t>(result.cells.size()));
  const std::vector<double> weights = weights_of_nodes(nodes, scale);
  result.weight.resize(std::size_t(nodes.beams + kBeamsAThread - 1) / kBeamsAThread * nodes.nodes);
  for (int j = 0; j < nodes.beams; ++j) {
    for (int c = 0; c < nodes.nodes; ++c) {
      BeamWeights& block = result.weight[std::size_t(j / kBeamsAThread) * nodes.nodes + c];
      block.of_beam[j % kBeamsAThread] =
          static_cast<float>(weights[std::size_t(j) * nodes.nodes + c]);
    }
  }
  return result;
}

// Lists the sectors that reach the two nodes of each row, with their weights at both.
void fill_sectors(const SynthesisSetup& setup, ArrayPowerTables& tables) {
  const std::vector<double> cosines = beam_cosines(setup.sonar);
  tables.row_offset.push_back(0);
  for (int row = 0; row < tables.grid.nodes / 2; ++row) {
    for (std::size_t j = 0; j < cosines.size(); ++j) {
      const int cell = tables.grid.cell_of(cosines[j]), first = cell / kCellsPerNode;
      const auto weight_at = [&](int node) {
        const bool reached = node >= first && node < first + kPatternTaps;
        return reached ? tables.cell_weight[cell * kPatternTaps + node - first] : 0.0f;
      };
      const float even = weight_at(2 * row), odd = weight_at(2 * row + 1);
      if (even == 0 && odd == 0) continue;
      tables.sectors.push_back({static_cast<std::uint32_t>(j), even, odd});
    }
    tables.row_offset.push_back(static_cast<std::uint32_t>(tables.sectors.size()));
  }
}

void fill_filters(const NodePlan& plan, ArrayPowerTables& tables) {
  tables.row_filters = plan.row_filter.empty() ? 1 : plan.rows;
  for (const Complex& f : plan.row_filter) tables.filter.push_back(narrow(f));
  if (!plan.row_filter.empty()) return;
  for (int k = 0; k < plan.transform; ++k) tables.filter.push_back(narrow(plan.grid.lower[k]));
  for (int k = 0; k < plan.transform; ++k) tables.filter.push_back(narrow(plan.grid.upper[k]));
}

}  // namespace

DeviceSpread spread_of(const SpreadKernel& kernel, int transform) {
  ENSONIFY_ASSERT(kernel.points > 0 && kernel.width <= kGridLanes);
  DeviceSpread spread;
  spread.points = kernel.points;
  spread.width = kernel.width;
  spread.degree = kernel.degree;
  const std::size_t pairs = std::size_t(kernel.polynomial().chunks) * 8;
  for (int d = 0; d <= kernel.degree; ++d) {
    for (int l = 0; l < kernel.width; ++l) {
      spread.coefficient.push_back(kernel.coefficient[d * pairs + 2 * l]);
    }
  }
  spread.filter.resize(transform);
  spread.upper_filter.resize(transform);
  spread.cell_filter.resize(transform);
  return spread;
}

DeviceSpread series_spread(const std::vector<Complex>& spectrum, double error) {
  const int bins = static_cast<int>(spectrum.size()), half = bins / 2;
  const SpreadKernel kernel = choose_spread_kernel(spectrum, -half, error);
  DeviceSpread spread = spread_of(kernel, bins);
  for (int k = -half; k < half; ++k) {
    const int bin = k < 0 ? k + bins : k;
    spread.filter[bin] = narrow(spectrum[k + half] * kernel.correction[std::abs(k)]);
    spread.cell_filter[bin] = narrow(spectrum[k + half]);
  }
  return spread;
}

BeamTables make_beam_tables(const SynthesisSetup& setup) {
  const std::vector<Complex> spectrum = pulse_spectrum(setup.sonar, setup.record.transform);
  const Mixing mixing = make_mixing(setup.sonar);
  BeamTables tables;
  tables.series = series_spread(spectrum);
  tables.power = power_spread(pulse_autospectrum(spectrum));
  tables.mixing = mixing_by_nodes(mixing, false);
  tables.power_mixing = mixing_by_nodes(mixing, true);
  return tables;
}

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
  const std::vector<Complex> flat(bins, 1);
  tables.spread = series_spread(flat, kFlatError);
  if (setup.sonar.array) {
    const SpreadKernel kernel = choose_spread_kernel(flat, -bins / 2, kFlatError);
    const ElementGroups groups = choose_groups(array_setup(setup), kernel, kMostGroupElements);
    tables.groups = groups_of(kernel,
                              {groups.wide.coefficient.data(), kernel.width, groups.wide.terms,
                               static_cast<float>(1 / groups.reach)},
                              groups.elements, groups.exact_range_m);
  }
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
    filter[bin] = narrow(spectrum[m] * static_cast<double>(tables.spread.filter[bin].re));
  }
  return filter;
}

NodesInUse nodes_in_use(const DopplerNodes& nodes, const PingBatch& batch, const Workers& workers) {
  const std::size_t pings = batch.pings.size();
  std::vector<std::set<int>> bands(pings);
  workers.for_each(pings, [&](std::size_t p) {
    const std::uint32_t* at = batch.shift_offset.data() + batch.pings[p].first_offset;
    const std::size_t sectors = batch.shift_offset.size() / pings - 1;
    const std::span<const DopplerRecord> all = batch.shifts;
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

ArrayTables make_array_tables(const SynthesisSetup& setup) {
  const Sonar& sonar = setup.sonar;
  const SynthesisTables shared{
      array_setup(setup), {}, pulse_spectrum(sonar, setup.record.transform), {}};
  const auto plan = make_array_plan(shared, {kGridLanes, kMostGroupElements});
  ENSONIFY_ASSERT(plan != nullptr);
  const ArrayGeometry& geometry = plan->geometry;
  ArrayTables tables;
  tables.groups = groups_of(plan->spread, plan->kernel, plan->group_elements, plan->exact_range_m);
  for (const Complex& f : plan->filter) tables.filter.push_back(narrow(f));
  tables.y_m = geometry.y_m;
  const auto noise = static_cast<float>(std::sqrt(element_noise_power_pa2(geometry, 1)));
  for (std::size_t n = 0; n < geometry.y_m.size(); ++n) {
    tables.weight.push_back(static_cast<float>(geometry.weight[n]));
    tables.response.push_back(narrow(geometry.response[n]));
    tables.noise_factor.push_back(geometry.response[n] == Complex(0) ? 0.0f : noise);
  }
  tables.beam_cosine = beam_cosines(sonar);
  for (const double azimuth : beam_azimuths_rad(sonar)) {
    for (std::size_t n = 0; n < geometry.y_m.size(); ++n) {
      const double turns = sonar.frequency_hz *
                           steering_delay_s(geometry.y_m[n], azimuth, setup.water.sound_speed_m_s);
      tables.steering.push_back(
          narrow(std::polar(geometry.weight[n], 2 * kPi * (turns - std::rint(turns)))));
    }
  }
  fill_taps(setup, plan->taps, tables);
  tables.nodes = node_tables(*plan);
  return tables;
}

ArrayPowerTables make_array_power_tables(const SynthesisSetup& setup) {
  const Sonar& sonar = setup.sonar;
  const ArrayGeometry geometry = make_array_geometry(sonar);
  SynthesisTables shared{setup, {}, pulse_spectrum(sonar, setup.record.transform), {}};
  shared.autospectrum = pulse_autospectrum(shared.spectrum);
  ArrayPowerTables tables;
  tables.grid = make_power_grid(setup);
  const std::unique_ptr<const NodePlan> plan = make_array_power_plan(shared, tables.grid);
  tables.power = spread_of(plan->grid.spread, setup.record.transform);
  tables.cell_weight = plan->weight;
  fill_filters(*plan, tables);
  const double wavelength_m = setup.water.sound_speed_m_s / sonar.frequency_hz;
  for (int q = 0; q < tables.grid.nodes; ++q) {
    const double u = tables.grid.node_u(q);
    const double heard = element_pattern(u, sonar.array->element_width_m, wavelength_m);
    tables.node_cosine.push_back(u);
    tables.node_heard.push_back(static_cast<float>(heard * heard));
  }
  for (std::size_t n = 0; n < geometry.y_m.size(); ++n) {
    tables.received.push_back(narrow(geometry.weight[n] * geometry.response[n]));
  }
  fill_sectors(setup, tables);
  tables.blocks = pattern_blocks(setup);
  return tables;
}

}  // namespace ensonify
