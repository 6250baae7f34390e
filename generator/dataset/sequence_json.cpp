#include "dataset/sequence_json.h"

#include "core/units.h"
#include "dataset/layout.h"

namespace ensonify {
namespace {

const char* name_of(const Pulse& pulse) {
  return pulse.shape == PulseShape::gaussian ? "gaussian" : "flat";
}

const char* name_of(Normalization normalization) {
  return normalization == Normalization::calibrated ? "calibrated" : "mean_square";
}

const char* name_of(SpeckleMode speckle) {
  return speckle == SpeckleMode::per_ping ? "per_ping" : "per_ray";
}

Json sonar_json(const Sonar& sonar) {
  return {{"frequency_hz", sonar.frequency_hz},
          {"bandwidth_hz", sonar.bandwidth_hz},
          {"pulse", name_of(sonar.pulse)},
          {"source_level_db", sonar.source_level_db},
          {"source_pressure_pa_m", source_pressure_pa_m(sonar)},
          {"range_min_m", sonar.range_min_m},
          {"range_max_m", sonar.range_max_m},
          {"beams",
           {{"count", sonar.beam_count},
            {"spacing_rad", sonar.beam_spacing_rad},
            {"width_rad", sonar.beam_width_rad},
            {"first_azimuth_rad", beam_azimuth_rad(sonar, 0)},
            {"order", "beam 0 to starboard (most negative azimuth), azimuth grows to port"}}},
          {"elevation",
           {{"width_rad", sonar.elevation_width_rad}, {"fan_rad", sonar.elevation_fan_rad}}},
          {"rays", {{"elevation", sonar.rays_elevation}, {"azimuth", sonar.rays_azimuth}}},
          {"normalization", name_of(sonar.normalization)}};
}

Json record_json(const SequenceInfo& info) {
  return {{"samples", info.record.samples},
          {"transform", info.record.transform},
          {"sample_interval_s", info.record.sample_interval_s},
          {"range_step_m", sample_range_m(info.sonar, info.water, 1)}};
}

// The beam model in words and formulas; every symbol is a number of this file or a field of
// scatterers/*.npy.
Json model_json(const Sonar& sonar) {
  const bool gaussian = sonar.pulse.shape == PulseShape::gaussian;
  const bool calibrated = sonar.normalization == Normalization::calibrated;
  return {
      {"series",
       "p_j(t_n) = S0 sum_i B(theta_beam(i) - theta_j)/N_j a_i gain_i exp(-i 2 pi f_c tau_i) "
       "s(t_n - tau_i); plus noise where `noise` is not null"},
      {"symbols",
       {{"S0", "sonar.source_pressure_pa_m"},
        {"f_c", "sonar.frequency_hz"},
        {"b", "sonar.bandwidth_hz"},
        {"N", "record.samples"},
        {"M", "record.transform"},
        {"t_n", "n / b, n = 0 ... N-1"},
        {"theta_j", "azimuth_rad.npy[j]"},
        {"beam(i)", "scatterers beam"},
        {"a_i", "scatterers amp_re + i amp_im"},
        {"gain_i", "scatterers gain: spreading, absorption and elevation pattern, both ways"},
        {"tau_i", "scatterers delay_s, two-way"}}},
      {"beam_pattern",
       "B(theta) = sin(pi x)/(pi x), x = 0.884 sin(theta) / sonar.beams.width_rad; B(0) = 1"},
      {"beam_normalization",
       calibrated ? "N_j = 1" : "N_j = sqrt(sum over beams i of B(theta_i - theta_j)^2)"},
      {"pulse",
       "s(t) = sum_m W(d_m) exp(i 2 pi d_m t) / sum_m W(d_m), d_m = (m - M/2) b/M, m = 0 ... M-1; "
       "the record is one period of it, t modulo M/b"},
      {"pulse_spectrum", std::string(gaussian ? "W(d) = exp(-(pi d / b)^2) T(d)" : "W(d) = T(d)") +
                             "; T(d) = 1 for |d| <= 0.4 b, (1 + cos(pi (|d|/b - 0.4)/0.1))/2 for "
                             "0.4 b < |d| <= 0.5 b"}};
}

Json instance_json(const Instance& instance) {
  Json json = {{"id", instance.id},
               {"name", instance.name},
               {"class_id", instance.class_id},
               {"class", instance.class_name},
               {"point_target", instance.kind == InstanceKind::point_target}};
  if (instance.kind == InstanceKind::point_target) {
    json["target_strength_db"] = number_or_null(instance.target_strength_db);
  } else {
    json["material"] = instance.material;
    json["reflectivity"] = instance.scattering.reflectivity;
  }
  return json;
}

Json cartesian_json(const CartesianGrid& grid) {
  return {{"height_px", grid.height_px},
          {"width_px", grid.width_px},
          {"metres_per_pixel", grid.m_per_px},
          {"x_top_m", grid.x_top_m},
          {"y_left_m", grid.y_left_m},
          {"pixel_centre",
           "x = x_top_m - (row + 0.5) metres_per_pixel, y = y_left_m - (column + 0.5) "
           "metres_per_pixel; x along the boresight, y to port"}};
}

Json axes_json() {
  return {{"timeseries", "complex64 [beams, samples], Pa (rms), complex baseband"},
          {"polar", "rows: samples, nearest first; columns: beams, 0 first"},
          {"cartesian", "the fan from above: boresight up, port left; nearest neighbour"},
          {"first_return_m", "float32 [pings, beams], NaN: none"},
          {"level", "20 log10|p| + 120, dB re 1 uPa; -99 where there is no energy"},
          {"frames",
           "world: x east, y north, z up; sonar: x along the boresight, y to port, z up; "
           "quaternions w, x, y, z turn sonar into world"}};
}

}  // namespace

Json sequence_head(const SequenceInfo& info, const std::vector<std::string>& each_ping,
                   std::uint64_t bytes) {
  Json instances = Json::array();
  for (const Instance& instance : info.instances) instances.push_back(instance_json(instance));
  Json noise;
  if (info.noise_spectrum_level_db) {
    noise = {{"spectrum_level_db", *info.noise_spectrum_level_db}, {"unit", "dB re 1 uPa^2/Hz"}};
  }
  return {{"ensonify_sequence", 1},
          {"sequence", info.sequence},
          {"seed", info.seed},
          {"split", info.split},
          {"pings", Json::array({info.first_ping, info.last_ping})},
          {"sonar", sonar_json(info.sonar)},
          {"water",
           {{"sound_speed_m_s", info.water.sound_speed_m_s},
            {"absorption_db_m", info.water.absorption_db_m}}},
          {"record", record_json(info)},
          {"scattering",
           {{"speckle", name_of(info.speckle)}}},
          {"noise", std::move(noise)},
          {"model", model_json(info.sonar)},
          {"png",
           info.output.png ? Json({{"scale", "db"}, {"db", info.png_db_limits}}) : Json(nullptr)},
          {"cartesian", info.cartesian ? cartesian_json(*info.cartesian) : Json(nullptr)},
          {"classes", info.classes},
          {"instances", std::move(instances)},
          {"axes", axes_json()},
          {"each_ping", each_ping},
          {"bytes", bytes}};
}

std::string files_opening(const Json& head) {
  std::string text = json_text(head);
  text.resize(text.rfind('\n', text.size() - 2));  // without the last brace
  return text + ",\n  \"files\": [";
}

std::string file_line(const FileEntry& entry, bool first) {
  return (first ? "\n    " : ",\n    ") + json_line(json_of(entry));
}

std::string files_closing() { return "\n  ]\n}\n"; }

bool sequence_is_whole(const std::filesystem::path& dir, std::uint32_t sequence) {
  const std::string folder = layout::sequence_folder(sequence) + "/";
  if (!listed_file_size(dir, folder + layout::kSequenceJson)) return false;
  const auto text = read_file(dir / (folder + layout::kSequenceJson));
  if (!text) return false;
  bool whole = true;
  const auto head = parse_manifest(*text, [&](const FileEntry& entry) {
    whole = whole && listed_file_size(dir, folder + entry.path) == entry.bytes;
  });
  return head && whole && count_at(*head, "ensonify_sequence") &&
         count_at(*head, "sequence") == sequence;
}

}  // namespace ensonify
