#include "export/sonar_beam_group.h"

#include <cmath>
#include <limits>
#include <utility>

#include "acoustics/pattern.h"
#include "core/units.h"
#include "dataset/read_pictures.h"
#include "export/ping_values.h"
#include "export/sonar_numbers.h"

namespace ensonify {
namespace {

constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
constexpr double kPascalDb = 120;  // 1 Pa, dB re 1 uPa
const std::string kBeams = "/Sonar/Beam_group1/";
const std::string kPosition = kPositionGroup + std::string("/");
const std::string kAttitude = kAttitudeGroup + std::string("/");
const std::string kGyro = kGyroGroup + std::string("/");

// The values are nominal ones in the sense of the convention.
NetcdfAttributes nominal(const char* long_name, const char* units) {
  return described(long_name, units, {{"substitute_value_used", 1}});
}

template <class Value>
std::vector<float> by_beam(const Sonar& sonar, Value value) {
  std::vector<float> values;
  for (int j = 0; j < sonar.beam_count; ++j) values.push_back(static_cast<float>(value(j)));
  return values;
}

}  // namespace

void make_time_axis(NetcdfFile& file, const std::string& path, const char* long_name,
                    std::uint64_t pings) {
  file.coordinate({path,
                   NetcdfType::u64,
                   {},
                   described(long_name, "nanoseconds since 1970-01-01 00:00:00Z",
                             {{"axis", std::string("T")},
                              {"calendar", std::string("gregorian")},
                              {"standard_name", std::string("time")}})},
                  pings);
}

SonarBeamGroup::SonarBeamGroup(NetcdfFile& file, const StoredSequence& sequence)
    : file_(file), sequence_(sequence), info_(sequence.manifest.info), sonar_(info_.sonar) {}

void SonarBeamGroup::make(const std::string& program_version) {
  make_types(program_version);
  make_dimensions();
  make_ping_values();
  make_series();
  make_flags();
  make_directions();
  make_widths();
  make_transmission();
  make_equation();
}

Status SonarBeamGroup::write(const ExportJob& job, const StoredPing& ping, std::uint64_t at,
                             std::uint64_t time_ns) {
  const auto series = read_series(job.dataset, sequence_, ping.ping);
  if (!series) return series.error();
  std::vector<float> real, imaginary;
  real.reserve(series->size());
  imaginary.reserve(series->size());
  for (const std::complex<float>& value : *series) {
    real.push_back(value.real());
    imaginary.push_back(value.imag());
  }
  file_.write_ragged_at(kBeams + "backscatter_r", at, real, sequence_.beams);
  file_.write_ragged_at(kBeams + "backscatter_i", at, imaginary, sequence_.beams);
  // Nothing was added to the time series that depends on time.
  const std::vector<float> no_gain(sequence_.samples, 0.F);
  file_.write_ragged_at(kBeams + "time_varied_gain", at, no_gain, 1);
  for (const std::string& time :
       {kBeams + "ping_time", kPosition + "time", kAttitude + "time", kGyro + "time"}) {
    file_.write_at(time, at, &time_ns);
  }
  for (const Constant& constant : constants_) {
    file_.write_at(constant.path, at, constant.values.data());
  }
  const std::vector<std::int32_t> counts(sequence_.beams,
                                         static_cast<std::int32_t>(sequence_.samples));
  const std::vector<std::int32_t> zeros(sequence_.beams, 0);
  file_.write_at(kBeams + "sample_count", at, counts.data());
  file_.write_at(kBeams + "transmit_beam_index", at, zeros.data());
  file_.write_at(kBeams + "transmit_transducer_index", at, zeros.data());
  write_flags(at);
  write_pose(ping.sonar_in_world, at);
  return {};
}

void SonarBeamGroup::make_types(const std::string& program_version) {
  file_.group("/Sonar", {{"sonar_manufacturer", std::string("ensonify")},
                         {"sonar_model", std::string("simulated")},
                         {"sonar_software_name", std::string("ensonify")},
                         {"sonar_software_version", program_version},
                         {"sonar_type", std::string("omni-sonar")}});
  file_.enumeration("/Sonar/beam_stabilisation_t", {{"not_stabilised", 0}, {"stabilised", 1}});
  file_.enumeration("/Sonar/beam_t", {{"single", 0},
                                      {"split_aperture_angles", 1},
                                      {"split_aperture_4_subbeams", 2},
                                      {"split_aperture_3_subbeams", 3},
                                      {"split_aperture_3_1_subbeams", 4}});
  file_.enumeration(
      "/Sonar/conversion_equation_t",
      {{"type_1", 1}, {"type_2", 2}, {"type_3", 3}, {"type_4", 4}, {"type_5", 5}, {"type_6", 6}});
  file_.enumeration("/Sonar/transmit_t", {{"CW", 0}, {"LFM", 1}, {"HFM", 2}});
  file_.group("/Sonar/Beam_group1", {{"beam_mode", std::string("horizontal")},
                                     {"preferred_MRU", 0},
                                     {"preferred_position", 0},
                                     {"preferred_gyro", 0}});
  file_.enumerated("/Sonar/Beam_group1", "conversion_equation_type", "/Sonar/conversion_equation_t",
                   1);
  file_.ragged_type(kBeams + "sample_t");
}

void SonarBeamGroup::make_dimensions() {
  file_.coordinate(
      {kBeams + "beam", NetcdfType::text, {}, {{"long_name", std::string("Beam name")}}},
      sequence_.beams);
  std::vector<std::string> names;
  for (std::uint64_t j = 0; j < sequence_.beams; ++j) names.push_back(std::to_string(j));
  file_.write_texts(kBeams + "beam", names);
  make_time_axis(file_, kBeams + "ping_time", "Time-stamp of each ping", sequence_.row.pings());
  file_.dimension(kBeams + "tx_beam", 1);
  file_.coordinate(
      {kBeams + "frequency", NetcdfType::f32, {}, described("Calibration gain frequencies", "Hz")},
      1);
  const auto carrier = static_cast<float>(sonar_.frequency_hz);
  file_.write(kBeams + "frequency", &carrier);
}

// Values of each ping, along its time.
void SonarBeamGroup::make_ping_values() {
  const auto add = [&](const std::string& group, const char* time, const char* name,
                       const char* long_name, const char* units, NetcdfType type,
                       const NetcdfAttributes& more = {}) {
    file_.variable({group + name, type, {group + time}, described(long_name, units, more)});
  };
  constexpr auto kF32 = NetcdfType::f32, kF64 = NetcdfType::f64;
  const NetcdfAttributes missing = {{"_FillValue", kNowhere}},
                         dry = {{"_FillValue", static_cast<float>(kNowhere)}};
  add(kPosition, "time", "latitude", "latitude", "degrees_north", kF64, missing);
  add(kPosition, "time", "longitude", "longitude", "degrees_east", kF64, missing);
  add(kPosition, "time", "local_x", "x of the world, to the east", "m", kF64);
  add(kPosition, "time", "local_y", "y of the world, to the north", "m", kF64);
  add(kPosition, "time", "local_z", "z of the world, up", "m", kF64);
  add(kAttitude, "time", "heading", "Platform heading(true)", "degrees_north", kF32);
  add(kAttitude, "time", "pitch", "pitch angle", "arc_degree", kF32);
  add(kAttitude, "time", "roll", "roll angle", "arc_degree", kF32);
  add(kAttitude, "time", "vertical_offset", "Platform vertical offset from nominal", "m", kF32);
  add(kGyro, "time", "heading", "Platform heading(true)", "degree", kF32);
  add(kBeams, "ping_time", "platform_latitude", "latitude", "degrees_north", kF64, missing);
  add(kBeams, "ping_time", "platform_longitude", "longitude", "degrees_east", kF64, missing);
  add(kBeams, "ping_time", "platform_heading", "Platform heading(true)", "degrees_north", kF32);
  add(kBeams, "ping_time", "platform_pitch", "pitch angle", "arc_degree", kF32);
  add(kBeams, "ping_time", "platform_roll", "roll angle", "arc_degree", kF32);
  add(kBeams, "ping_time", "platform_vertical_offset",
      "Platform vertical distance from reference point to the water line", "m", kF32, dry);
  add(kBeams, "ping_time", "sample_interval", "Interval between recorded raw data samples", "s",
      kF32);
  add(kBeams, "ping_time", "sound_speed_at_transducer",
      "Indicative sound speed at ping time and transducer depth", "m/s", kF32);
}

void SonarBeamGroup::add(const char* name, NetcdfType type, std::vector<std::string> dimensions,
                         const NetcdfAttributes& attributes, const std::string& named) {
  for (std::string& dimension : dimensions) dimension = kBeams + dimension;
  file_.variable({kBeams + name, type, std::move(dimensions), attributes, named});
}

void SonarBeamGroup::make_series() {
  const std::string ragged = kBeams + "sample_t";
  add("backscatter_r", NetcdfType::named, {"ping_time", "beam"},
      described("Raw backscatter measurements (real part), rms pressure", "Pa"), ragged);
  add("backscatter_i", NetcdfType::named, {"ping_time", "beam"},
      described("Raw backscatter measurements (imaginary part), rms pressure", "Pa"), ragged);
  add("time_varied_gain", NetcdfType::named, {"ping_time"},
      described("Time-varied-gain coefficients", "dB"), ragged);
  add("sample_count", NetcdfType::i32, {"ping_time", "beam"},
      described("Number of samples per ping in each beam", "1"));
}

void SonarBeamGroup::make_flags() {
  const auto index = [](const char* long_name) { return described(long_name, "1"); };
  add("receive_transducer_index", NetcdfType::i32, {"beam"}, index("Receive transducer index"));
  const std::vector<std::int32_t> zeros(sequence_.beams, 0);
  file_.write(kBeams + "receive_transducer_index", zeros.data());
  add("transmit_beam_index", NetcdfType::i32, {"ping_time", "beam"},
      index("Transmit beam index associated with the given beam"));
  add("transmit_transducer_index", NetcdfType::i32, {"ping_time", "tx_beam"},
      index("Transmit transducer index"));
  add("beam_stabilisation", NetcdfType::named, {"ping_time"},
      {{"long_name", std::string("Beam stabilisation applied (or not)")}},
      "/Sonar/beam_stabilisation_t");
  add("beam_type", NetcdfType::named, {}, {{"long_name", std::string("Type of beam")}},
      "/Sonar/beam_t");
  constexpr std::int8_t kSingle = 0;
  file_.write(kBeams + "beam_type", &kSingle);
  add("transmit_type", NetcdfType::named, {"ping_time", "tx_beam"},
      {{"long_name", std::string("Type of transmitted pulse")}}, "/Sonar/transmit_t");
  add("non_quantitative_processing", NetcdfType::i16, {"ping_time"},
      {{"long_name", std::string("Presence or not of non-quantitative processing")},
       {"flag_meanings",
        std::string("no_non_quantitative_processing beams_divided_by_root_of_squared_weights")},
       {"flag_values", std::vector<short>{0, 1}}});
}

void SonarBeamGroup::add_constant(const char* name, const char* dimension,
                                  const NetcdfAttributes& attributes, std::vector<float> values) {
  add(name, NetcdfType::f32, {"ping_time", dimension}, attributes);
  constants_.push_back({kBeams + name, std::move(values)});
}

void SonarBeamGroup::add_constant(const char* name, const char* dimension,
                                  const NetcdfAttributes& attributes, double value) {
  const bool of_beams = std::string(dimension) == "beam";
  add_constant(name, dimension, attributes,
               std::vector<float>(of_beams ? sequence_.beams : 1, static_cast<float>(value)));
}

void SonarBeamGroup::make_directions() {
  const auto azimuth = [&](int j) { return beam_azimuth_rad(sonar_, j); };
  const char* component = "Component of the beam's direction in the platform coordinate system";
  add_constant("beam_direction_x", "beam", described(component, "1"),
               by_beam(sonar_, [&](int j) { return std::cos(azimuth(j)); }));
  add_constant("beam_direction_y", "beam", described(component, "1"),
               by_beam(sonar_, [&](int j) { return -std::sin(azimuth(j)); }));
  add_constant("beam_direction_z", "beam", described(component, "1"), 0);
  // Rz(psi) Ry(90) Rx(phi) turns the z axis to (cos phi, -sin phi, 0): phi is the azimuth.
  const char* turn = "Rotation of the beam coordinate system about an axis of the platform";
  add_constant("rx_beam_rotation_phi", "beam", described(turn, "arc_degree"),
               by_beam(sonar_, [&](int j) { return degrees(azimuth(j)); }));
  add_constant("rx_beam_rotation_theta", "beam", described(turn, "arc_degree"), 90);
  add_constant("rx_beam_rotation_psi", "beam", described(turn, "arc_degree"), 0);
  add_constant("tx_beam_rotation_phi", "tx_beam", described(turn, "arc_degree"), 0);
  add_constant("tx_beam_rotation_theta", "tx_beam", described(turn, "arc_degree"), 90);
  add_constant("tx_beam_rotation_psi", "tx_beam", described(turn, "arc_degree"), 0);
}

void SonarBeamGroup::make_widths() {
  const double upright = degrees(one_way_elevation_width_rad(sonar_));
  add_constant(
      "beamwidth_receive_major", "beam",
      described("Half power one-way receive beam width along major (horizontal) axis of beam",
                "arc_degree"),
      by_beam(sonar_, [&](int j) { return degrees(receive_width_rad(info_, j)); }));
  add_constant("beamwidth_receive_minor", "beam",
               nominal("Half power one-way receive beam width along minor (vertical) axis of beam",
                       "arc_degree"),
               upright);
  add_constant(
      "beamwidth_transmit_major", "tx_beam",
      described("Half power one-way transmit beam width along major (horizontal) axis of beam",
                "arc_degree"),
      sonar_.transmit_width_rad > 0 ? degrees(sonar_.transmit_width_rad) : 360);
  add_constant("beamwidth_transmit_minor", "tx_beam",
               nominal("Half power one-way transmit beam width along minor (vertical) axis of beam",
                       "arc_degree"),
               upright);
  add_constant("equivalent_beam_angle", "beam", nominal("Equivalent beam angle", "sr"),
               by_beam(sonar_, [&](int j) { return equivalent_beam_angle_sr(info_, j); }));
}

void SonarBeamGroup::make_transmission() {
  const Pulse& pulse = sonar_.pulse;
  const bool sweeps = pulse.shape == PulseShape::lfm;
  const bool lasts = sweeps || pulse.shape == PulseShape::cw;
  const double band = sweeps ? sonar_.bandwidth_hz / 2 : 0, carrier = sonar_.frequency_hz;
  const double effective = effective_pulse_s(info_);
  add_constant("transmit_frequency_start", "tx_beam",
               described("Start frequency in transmitted pulse", "Hz"), carrier - band);
  add_constant("transmit_frequency_stop", "tx_beam",
               described("Stop frequency in transmitted pulse", "Hz"), carrier + band);
  add_constant("transmit_bandwidth", "tx_beam",
               described("Nominal bandwidth of transmitted pulse", "Hz"), sonar_.bandwidth_hz);
  add_constant("transmit_duration_nominal", "tx_beam",
               lasts ? described("Nominal duration of transmitted pulse", "s")
                     : nominal("Nominal duration of transmitted pulse", "s"),
               lasts ? pulse.duration_s : effective);
  add_constant("receive_duration_effective", "tx_beam",
               described("Effective duration of received pulse", "s"), effective);
  // The name of the same in version 1.0.
  add_constant("transmit_duration_equivalent", "tx_beam",
               described("Equivalent duration of transmitted pulse", "s"), effective);
  add_constant("sample_time_offset", "tx_beam",
               described("Time offset that is subtracted from the timestamp of each sample", "s"),
               0);
  add_constant("blanking_interval", "beam",
               described("Amount of time during reception where samples are discarded", "s"), 0);
}

// Type 1: TS = 20 lg|p| + 40 lg r + 2 alpha r - 10 lg(P lambda^2/(16 pi^2)) - G. With a power of
// 1 W, the gain G contains the source level and the unit of the samples.
void SonarBeamGroup::make_equation() {
  const double wavelength = info_.water.sound_speed_m_s / sonar_.frequency_hz;
  const double level = sonar_.source_level_db - kPascalDb;
  const double spread = 20 * std::log10(wavelength / (4 * kPi));
  add_constant("transmit_power", "tx_beam", nominal("Nominal transmit power", "W"), 1);
  add("transducer_gain", NetcdfType::f32, {"ping_time", "beam", "frequency"},
      nominal("Gain of transducer", "dB"));
  constants_.push_back({kBeams + "transducer_gain", by_beam(sonar_, [&](int j) {
                          return level - spread + 20 * std::log10(transmit_on_axis(sonar_, j));
                        })});
  add_constant("transmit_source_level", "tx_beam",
               described("Transmit source level (re 1 μPa at 1 m)", "dB"), sonar_.source_level_db);
  add_constant("receiver_sensitivity", "beam", described("Receiver sensitivity (re 1/μPa)", "dB"),
               -kPascalDb);
  add_constant("gain_correction", "beam", described("Gain correction", "dB"), 0);
}

void SonarBeamGroup::write_flags(std::uint64_t at) {
  constexpr std::int8_t kNotStabilised = 0;
  const std::int8_t pulse = sonar_.pulse.shape == PulseShape::lfm ? 1 : 0;
  const std::int16_t processing = sonar_.normalization == Normalization::mean_square ? 1 : 0;
  file_.write_at(kBeams + "beam_stabilisation", at, &kNotStabilised);
  file_.write_at(kBeams + "transmit_type", at, &pulse);
  file_.write_at(kBeams + "non_quantitative_processing", at, &processing);
}

void SonarBeamGroup::write_pose(const Pose& pose, std::uint64_t at) {
  const auto put64 = [&](const std::string& path, double value) {
    file_.write_at(path, at, &value);
  };
  const auto put = [&](const std::string& path, double value) {
    const auto number = static_cast<float>(value);
    file_.write_at(path, at, &number);
  };
  const LogAttitude attitude = attitude_of(pose);
  for (const std::string& prefix : {kPosition, kBeams + "platform_"}) {
    put64(prefix + "latitude", kNowhere);
    put64(prefix + "longitude", kNowhere);
  }
  put64(kPosition + "local_x", pose.position_m.x);
  put64(kPosition + "local_y", pose.position_m.y);
  put64(kPosition + "local_z", pose.position_m.z);
  for (const std::string& prefix : {kAttitude, kBeams + "platform_"}) {
    put(prefix + "heading", attitude.heading_deg);
    put(prefix + "pitch", attitude.pitch_deg);
    put(prefix + "roll", attitude.roll_deg);
  }
  put(kGyro + "heading", attitude.heading_deg);
  const double depth = depth_of(pose.position_m);
  put(kAttitude + "vertical_offset", depth);
  put(kBeams + "platform_vertical_offset", depth);
  put(kBeams + "sample_interval", info_.record.sample_interval_s);
  put(kBeams + "sound_speed_at_transducer", info_.water.sound_speed_m_s);
}

// Below the surface, where the world has one.
double SonarBeamGroup::depth_of(const Vec3& place) const {
  if (info_.multipath && info_.multipath->surface) return info_.multipath->surface->z_m - place.z;
  if (info_.water.profile) return info_.water.profile->surface_z_m - place.z;
  return kNowhere;
}

}  // namespace ensonify
