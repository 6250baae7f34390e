#include "scenario/parse.h"

namespace ensonify {
namespace {

// A number, or {from: {temperature_c, salinity_psu, depth_m}}.
void parse_sound_speed(Faults& faults, const Value& water_value, WaterSpec& water) {
  const auto speed = child(water_value, "sound_speed_m_s");
  if (!speed || speed->node->kind != NodeKind::map) {
    read_number(faults, water_value, "sound_speed_m_s", from_to(100, 10000), water.sound_speed_m_s);
    return;
  }
  if (!open_map(faults, *speed, {"from"})) return;
  const Value from = child_or_empty(*speed, "from");
  if (!open_map(faults, from, {"temperature_c", "salinity_psu", "depth_m"})) return;
  SoundSpeedSpec spec;
  read_number(faults, from, "temperature_c", from_to(-5, 40), spec.temperature_c, Need::required);
  read_number(faults, from, "salinity_psu", from_to(0, 45), spec.salinity_psu, Need::required);
  read_number(faults, from, "depth_m", from_to(0, 12000), spec.depth_m, Need::required);
  water.sound_speed_from = spec;
}

}  // namespace

void parse_water(const InputFolder& input, const Value& value, WaterSpec& water) {
  Faults& faults = input.faults;
  if (!open_map(faults, value, {"sound_speed_m_s", "profile", "absorption"})) return;
  parse_sound_speed(faults, value, water);
  if (const auto profile = child(value, "profile")) {
    parse_profile(input, *profile, water.profile.emplace());
  }
  const auto absorption = child(value, "absorption");
  if (!absorption) return;
  if (!open_map(faults, *absorption,
                {"fixed_db_m", "model", "temperature_c", "salinity_psu", "ph", "depth_m"})) {
    return;
  }
  const auto key = only_key_of(faults, *absorption, {"fixed_db_m", "model"},
                               "fixed_db_m (dB/m) or model (francois_garrison, ainslie_mccolm)");
  if (!key) return;
  if (*key == "fixed_db_m") {
    FixedAbsorptionSpec fixed;
    read_number(faults, *absorption, "fixed_db_m", from_to(0, 1000), fixed.db_m);
    refuse_useless(faults, *absorption, {"temperature_c", "salinity_psu", "ph", "depth_m"},
                   "beside fixed_db_m, accepted is either alone");
    water.absorption = fixed;
    return;
  }
  SeaAbsorptionSpec model;
  read_choice<AbsorptionModel>(faults, *absorption, "model",
                               {{"francois_garrison", AbsorptionModel::francois_garrison},
                                {"ainslie_mccolm", AbsorptionModel::ainslie_mccolm}},
                               model.model, Need::required);
  read_number(faults, *absorption, "temperature_c", from_to(-5, 60), model.temperature_c);
  read_number(faults, *absorption, "salinity_psu", from_to(0, 100), model.salinity_psu);
  read_number(faults, *absorption, "ph", from_to(5, 10), model.ph);
  read_number(faults, *absorption, "depth_m", from_to(0, 12000), model.depth_m);
  water.absorption = model;
}

}  // namespace ensonify
