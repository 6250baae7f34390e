#include "ping/prepare_sonar.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "acoustics/pulse.h"
#include "core/units.h"
#include "instrument/detector.h"
#include "instrument/front_end.h"
#include "ping/array_receiver.h"
#include "scenario/tables.h"

namespace ensonify {
namespace {

Water water_of(const WaterSpec& spec, double frequency_hz) {
  Water water;
  water.density_kg_m3 = spec.density_kg_m3;
  water.sound_speed_m_s = spec.sound_speed_m_s;
  if (const auto& from = spec.sound_speed_from) {
    water.sound_speed_m_s =
        sound_speed_m_s({from->temperature_c, from->salinity_psu, 8, from->depth_m});
  }
  if (const auto* fixed = std::get_if<FixedAbsorptionSpec>(&spec.absorption)) {
    water.absorption_db_m = fixed->db_m;
  } else {
    const auto& sea = std::get<SeaAbsorptionSpec>(spec.absorption);
    const SeaWater sea_water{sea.temperature_c, sea.salinity_psu, sea.ph, sea.depth_m};
    water.absorption_db_m = sea.model == AbsorptionModel::francois_garrison
                                ? francois_garrison_db_m(frequency_hz, sea_water)
                                : ainslie_mccolm_db_m(frequency_hz, sea_water);
  }
  return water;
}

// What depends on the water, and the widths of beams whose aperture hears another carrier.
void set_transmission(const Scenario& scenario, Sonar& sonar, Water& water) {
  if (!sonar.transmit) return;
  const TransmitSpec& spec = *scenario.sonar.transmit;
  if (!spec.interval_s) {
    sonar.transmit->interval_s =
        two_way_delay_s(sonar.range_max_m, water.sound_speed_m_s) + spec.turnaround_s;
  }
  if (sonar.transmit->frequency_hz.empty()) return;
  for (const double carrier_hz : sonar.transmit->frequency_hz) {
    water.group_absorption_db_m.push_back(water_of(scenario.water, carrier_hz).absorption_db_m);
  }
  if (!sonar.width_rad.empty()) return;
  for (int beam = 0; beam < sonar.beam_count; ++beam) {
    sonar.width_rad.push_back(sonar.beam_width_rad * sonar.frequency_hz /
                              carrier_of_beam_hz(sonar, beam));
  }
}

Result<std::optional<SoundProfile>> profile_of(const WaterSpec& spec) {
  if (!spec.profile) return std::optional<SoundProfile>();
  SoundProfile profile{0, spec.profile->depth_m, spec.profile->sound_speed_m_s};
  if (!spec.profile->file.empty()) {
    auto loaded = load_sound_profile(spec.profile->file);
    if (!loaded) {
      return Error{loaded.error().kind, "water.profile.file: " + loaded.error().message};
    }
    profile = std::move(*loaded);
  }
  profile.surface_z_m = spec.profile->surface_z_m;
  return std::optional(std::move(profile));
}

Result<std::vector<PulseTableRow>> pulse_table_of(const Scenario& scenario, const Sonar& sonar) {
  if (sonar.pulse.shape != PulseShape::table) return std::vector<PulseTableRow>();
  auto table = load_pulse_table(scenario.sonar.pulse.file, sonar);
  if (table) return table;
  return Error{table.error().kind, "sonar.pulse.table.file: " + table.error().message};
}

void set_beam_responses(const Scenario& scenario, Sonar& sonar) {
  if (!scenario.sonar.electronics) return;
  const double gain_db = scenario.sonar.electronics->beam_gain_error_db;
  const double phase_rad = radians(scenario.sonar.electronics->beam_phase_error_deg);
  if (gain_db == 0 && phase_rad == 0) return;
  sonar.front_end->beam_response =
      beam_responses(device_seed(scenario), sonar.beam_count, gain_db, phase_rad);
}

// Cells of looks that would be longer than this part of the record are refused.
constexpr double kLongestCell = 0.25;

// Of the narrowest sub-band, in samples.
double longest_cell(const Session& session, int looks) {
  const auto borders = sub_band_borders(session.sonar, looks, session.record.transform);
  double longest = 0;
  for (std::size_t k = 1; k < borders.size(); ++k) {
    longest = std::max(longest, 1 / (borders[k] - borders[k - 1]));
  }
  return longest;
}

Status check_looks(const Session& session) {
  const auto& detector = session.sonar.detector;
  if (!detector || detector->looks == 1) return {};
  const double most = kLongestCell * session.record.samples;
  const double cell = longest_cell(session, detector->looks);
  if (cell <= most) return {};
  int possible = detector->looks - 1;
  while (possible > 1 && longest_cell(session, possible) > most) --possible;
  const double step_m = range_step_m(session.sonar, session.water);
  return Error{
      ErrorKind::usage,
      fmt::format("sonar.detector.looks: in {} sub-bands of the pulse a range cell is "
                  "{:.3g} m long, more than a quarter of the record of {:.3g} m; expected "
                  "at most {}, or a higher bandwidth_hz",
                  detector->looks, cell * step_m, session.record.samples * step_m, possible)};
}

}  // namespace

Status prepare_sonar(const Scenario& scenario, bool has_cell, Session& session) {
  session.sonar = sonar_of(scenario);
  session.sonar.elevation_line =
      make_shaded_line(session.sonar.elevation_line.shading, session.sonar.elevation_width_rad);
  set_beam_responses(scenario, session.sonar);
  session.water = water_of(scenario.water, session.sonar.frequency_hz);
  set_transmission(scenario, session.sonar, session.water);
  session.mount = pose_of(scenario.sonar.mount);
  Result<std::vector<PulseTableRow>> pulse = pulse_table_of(scenario, session.sonar);
  Result<std::optional<SoundProfile>> profile = profile_of(scenario.water);
  if (std::optional<Error> error = all_errors(pulse, profile)) return *error;
  session.sonar.pulse.table = std::move(*pulse);
  session.water.profile = std::move(*profile);
  session.record = make_record(session.sonar, session.water, pulse_extent_s(session.sonar));
  if (!pulse_is_heard(session.sonar, session.record.transform)) {
    return Error{ErrorKind::usage,
                 "sonar.pulse.table.file: the amplitudes are zero at every bin of the record; "
                 "expected a table with amplitudes above zero across the band"};
  }
  if (Status can = check_looks(session); !can) return can.error();
  if (has_cell) {
    session.cell = resolution_cell(session.sonar, session.water, session.record.transform);
  }
  Result<std::optional<ArrayReceiver>> array =
      array_receiver(scenario, session.sonar, session.water, session.record);
  if (!array) return array.error();
  session.sonar.array = std::move(*array);
  return {};
}

Result<std::vector<double>> times_of(const Scenario& scenario, const Path& path,
                                     std::uint32_t sequence) {
  const FrameDrops drops{stream_key(device_seed(scenario), Stream::dropped, sequence),
                         scenario.sonar.recorder ? scenario.sonar.recorder->dropped : 0};
  const auto chosen = chosen_index(scenario);
  if (!chosen) return ping_times(scenario.trajectory, path, drops);
  const InstrumentSpec& instrument = scenario.rig[*chosen];
  const PingClock clock{ping_rate_hz(scenario), instrument.time_offset_s};
  Result<std::vector<double>> times = ping_times(scenario.trajectory, path, clock, drops);
  if (!times || !times->empty()) return times;
  return Error{ErrorKind::usage,
               fmt::format("rig.{}.time_offset_s: {} has no ping, because {:g} s after the start "
                           "of the trajectory the run is over; expected a time that all "
                           "instruments have in common",
                           *chosen, instrument.name, clock.offset_s)};
}

}  // namespace ensonify
