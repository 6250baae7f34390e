#include "synthesis/cuda/array_tables.h"

#include <cmath>

#include "acoustics/pulse.h"
#include "core/error.h"
#include "core/units.h"
#include "synthesis/cpu/array_plan.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

std::vector<double> beam_cosines(const Sonar& sonar) {
  std::vector<double> cosines;
  for (const double azimuth : beam_azimuths_rad(sonar)) cosines.push_back(std::sin(azimuth));
  return cosines;
}

void fill_taps(const SynthesisSetup& setup, const ArrayGeometry& geometry, ArrayTables& tables) {
  BeamTaps taps = make_beam_taps(setup, geometry);
  const int period = 2 * setup.record.transform;
  for (const double c : taps.correction) tables.correction.push_back(static_cast<float>(c));
  for (const std::int32_t at : taps.begin) {
    tables.begin.push_back((at % period + period) % period);
  }
  tables.tap = std::move(taps.tap);
}

// Of the sectors that reach a row's two nodes, each with its weights there.
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
  for (int k = 0; k < plan.transform; ++k) tables.filter.push_back(narrow(plan.filter[k]));
  for (int k = 0; k < plan.transform; ++k) tables.filter.push_back(narrow(plan.upper_filter[k]));
}

}  // namespace

ArrayTables make_array_tables(const SynthesisSetup& setup) {
  const Sonar& sonar = setup.sonar;
  const ArrayGeometry geometry = make_array_geometry(sonar);
  ArrayTables tables;
  tables.series = series_spread(pulse_spectrum(sonar, setup.record.transform));
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
  fill_taps(setup, geometry, tables);
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
  tables.power = spread_of(plan->spread, setup.record.transform);
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
