#include "dataset/model_json.h"

#include <cmath>

#include "core/units.h"
#include "dataset/array_json.h"

namespace ensonify {
namespace {

const char* name_of(Normalization normalization) {
  return normalization == Normalization::calibrated ? "calibrated" : "mean_square";
}

Json pulse_json(const Pulse& pulse) {
  Json json = {{"shape", name_of(pulse.shape)}};
  if (pulse.shape == PulseShape::lfm || pulse.shape == PulseShape::cw) {
    json["duration_s"] = pulse.duration_s;
  }
  if (pulse.shape == PulseShape::lfm) json["taper"] = pulse.taper;
  if (pulse.shape != PulseShape::table) return json;
  json["rows"] = Json::array();
  for (const PulseTableRow& row : pulse.table) {
    json["rows"].push_back({row.frequency_hz, row.amplitude, row.phase_rad});
  }
  return json;
}

Json shading_json(const SequenceInfo& info) {
  const BeamShading& shading = info.sonar.shading;
  Json json = {{"kind", name_of(shading.kind)},
               {"aperture_wavelengths", info.receive_aperture_wavelengths}};
  if (shading.kind == Shading::taylor || shading.kind == Shading::chebyshev) {
    json["side_lobe_db"] = shading.side_lobe_db;
  }
  if (shading.kind == Shading::taylor) json["nbar"] = shading.nbar;
  return json;
}

Json adc_json(const std::optional<Adc>& adc) {
  if (!adc) return nullptr;
  const double full_scale_pa = std::sqrt(mean_square_pa2(adc->full_scale_db));
  return {{"bits", adc->bits},
          {"full_scale_db", adc->full_scale_db},
          {"step_pa", std::ldexp(full_scale_pa, 1 - adc->bits)}};
}

const char* pattern_formula(Shading shading) {
  switch (shading) {
    case Shading::uniform:
      return "B(theta) = sin(pi u)/(pi u); B(0) = 1";
    case Shading::hann:
      return "B(theta) = sin(pi u)/(pi u) / (1 - u^2); B(0) = 1";
    case Shading::taylor:
      return "B(theta) = sin(pi u)/(pi u) prod_{n=1}^{nbar-1} (1 - u^2/(sigma^2 (A^2 + (n - "
             "1/2)^2))) / (1 - u^2/n^2), sigma = nbar/sqrt(A^2 + (nbar - 1/2)^2), cosh(pi A) = "
             "10^(-side_lobe_db/20)";
    case Shading::chebyshev:
      return "B(theta) = cos(pi sqrt(u^2 - A^2))/cosh(pi A), cosh(pi A) = 10^(-side_lobe_db/20)";
  }
  return "";
}

const char* shape_formula(PulseShape shape) {
  switch (shape) {
    case PulseShape::gaussian:
      return "exp(-(pi d / b)^2) T(d)";
    case PulseShape::flat:
    case PulseShape::lfm:
      return "T(d)";
    case PulseShape::cw:
      return "sin(pi d D)/(pi d D) T(d)";
    case PulseShape::table:
      return "A(f_c + d) exp(i phi(f_c + d)) T(d)";
  }
  return "";
}

const char* window_formula(Window window) {
  switch (window) {
    case Window::none:
      return "";
    case Window::hann:
      return " (1 + cos(2 pi d/b))/2";
    case Window::hamming:
      return " (0.54 + 0.46 cos(2 pi d/b))";
    case Window::blackman:
      return " (0.42 + 0.5 cos(2 pi d/b) + 0.08 cos(4 pi d/b))";
  }
  return "";
}

std::string spectrum_formula(const Pulse& pulse, Window window) {
  std::string text = std::string("W(d) = ") + shape_formula(pulse.shape) + window_formula(window);
  if (pulse.shape == PulseShape::lfm) {
    text +=
        "; T(d) = 1 for |d| <= (0.5 - e) b, (1 + cos(pi (|d|/b - 0.5 + e)/e))/2 for "
        "(0.5 - e) b < |d| <= 0.5 b; e = sonar.pulse.taper";
    return text;
  }
  text += "; T(d) = 1 for |d| <= 0.4 b, (1 + cos(pi (|d|/b - 0.4)/0.1))/2 for 0.4 b < |d| <= 0.5 b";
  if (pulse.shape == PulseShape::cw) text += "; D = sonar.pulse.duration_s";
  if (pulse.shape == PulseShape::table) {
    text +=
        "; A, phi: amplitude and unwrapped phase of sonar.pulse.rows, linear in frequency, A = 0 "
        "outside";
  }
  return text;
}

Json law_json(const Material& material) {
  if (material.law == ScatteringLaw::table) {
    Json rows = Json::array();
    for (std::size_t i = 0; i < material.table.grazing_rad.size(); ++i) {
      rows.push_back({degrees(material.table.grazing_rad[i]), material.table.strength_db[i]});
    }
    return {{"model", "table"}, {"rows", std::move(rows)}};
  }
  if (material.law == ScatteringLaw::lommel_seeliger) {
    return {{"model", "lommel_seeliger"}, {"reflectivity", material.reflectivity}};
  }
  return {{"model", "lambert"},
          {"reflectivity", material.reflectivity},
          {"exponent", material.lambert_exponent}};
}

Json coherent_json(const Material& material) {
  if (material.coherent == CoherentModel::rician) {
    return {{"model", "rician"}, {"k", material.rician_k}};
  }
  if (material.coherent == CoherentModel::kirchhoff) {
    return {{"model", "kirchhoff"},
            {"reflection", material.reflection},
            {"roughness_rms_m", material.roughness_rms_m}};
  }
  return nullptr;
}

}  // namespace

Json water_json(const Water& water) {
  Json json = {{"sound_speed_m_s", water.sound_speed_m_s},
               {"absorption_db_m", water.absorption_db_m}};
  if (const auto& profile = water.profile) {
    json["profile"] = {{"surface_z_m", profile->surface_z_m},
                       {"depth_m", profile->depth_m},
                       {"sound_speed_m_s", profile->speed_m_s}};
  }
  return json;
}

Json sonar_json(const SequenceInfo& info) {
  const Sonar& sonar = info.sonar;
  Json json = {{"frequency_hz", sonar.frequency_hz},
               {"bandwidth_hz", sonar.bandwidth_hz},
               {"pulse", pulse_json(sonar.pulse)},
               {"window", name_of(sonar.window)},
               {"processing_gain", info.processing_gain},
               {"source_level_db", sonar.source_level_db},
               {"source_pressure_pa_m", source_pressure_pa_m(sonar)},
               {"range_min_m", sonar.range_min_m},
               {"range_max_m", sonar.range_max_m},
               {"beams",
                {{"count", sonar.beam_count},
                 {"spacing_rad", sonar.beam_spacing_rad},
                 {"width_rad", sonar.beam_width_rad},
                 {"shading", shading_json(info)},
                 {"transmit_width_rad",
                  sonar.transmit_width_rad > 0 ? Json(sonar.transmit_width_rad) : Json(nullptr)},
                 {"first_azimuth_rad", beam_azimuth_rad(sonar, 0)},
                 {"order", "beam 0 to starboard (most negative azimuth), azimuth grows to port"}}},
               {"elevation",
                {{"width_rad", sonar.elevation_width_rad}, {"fan_rad", sonar.elevation_fan_rad}}},
               {"rays",
                {{"elevation", sonar.rays_elevation},
                 {"azimuth", sonar.rays_azimuth},
                 {"per_cell", sonar.rays_per_cell}}},
               {"adc", adc_json(sonar.adc)},
               {"normalization", name_of(sonar.normalization)}};
  if (sonar.array) json["receiver"] = receiver_json(info);
  return json;
}

constexpr const char* kMotion =
    "poses are those of transmission; the sonar hears scatterer i where it is tau_i later, and "
    "what moves throws its sound back where it is then. With eta_i = scatterers doppler, in place "
    "of s(t - tau_i) stands the pulse of the spectrum P(d') R(d) / (1 + eta_i), d' = (d - eta_i "
    "f_c)/(1 + eta_i), scaled as s is; P is the sent pulse, R the receiver's window and band";

Json model_json(const SequenceInfo& info) {
  const Sonar& sonar = info.sonar;
  const bool calibrated = sonar.normalization == Normalization::calibrated;
  Json json = {
      {"series",
       "p_j(t_n) = S0 sum_i B(theta_beam(i) - theta_j)/N_j a_i gain_i exp(-i 2 pi f_c tau_i) "
       "s(t_n - tau_i); plus the echoes of instances of kind volume; plus noise where `noise` is "
       "not null; then quantised where sonar.adc is not null"},
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
        {"gain_i",
         "scatterers gain: spreading, absorption, elevation and transmit pattern, both ways"},
        {"tau_i", "scatterers delay_s, two-way"},
        {"u", "sonar.beams.shading.aperture_wavelengths sin(theta)"}}},
      {"beam_pattern", pattern_formula(sonar.shading.kind)},
      {"beam_normalization",
       calibrated ? "N_j = 1" : "N_j = sqrt(sum over beams i of B(theta_i - theta_j)^2)"},
      {"pulse",
       "s(t) = S(t)/max|S|, S(t) = sum_m W(d_m) exp(i 2 pi d_m t), d_m = (m - M/2) b/M, m = 0 ... "
       "M-1, the maximum over t = k/(32 b); the record is one period of it, t modulo M/b"},
      {"pulse_spectrum", spectrum_formula(sonar.pulse, sonar.window)}};
  if (sonar.array) set_array_model(info, json);
  if (info.motion_within_ping) json["motion"] = kMotion;
  return json;
}

Json instance_json(const Instance& instance) {
  Json json = {{"id", instance.id},
               {"name", instance.name},
               {"class_id", instance.class_id},
               {"class", instance.class_name}};
  json["box"] = nullptr;
  if (instance.box) {
    const auto& [pose, size] = *instance.box;
    const auto& [p, q] = pose;
    json["box"] = {{"size_m", {size.x, size.y, size.z}},
                   {"centre_m", {p.x, p.y, p.z}},
                   {"quaternion_wxyz", {q.w, q.x, q.y, q.z}}};
  }
  switch (instance.kind) {
    case InstanceKind::surface:
      json["kind"] = "surface";
      json["material"] = instance.material;
      json["law"] = law_json(instance.scattering);
      json["vertex_reflectivity"] = instance.vertex_reflectivity;
      json["coherent"] = coherent_json(instance.scattering);
      for (const InstancePart& part : instance.parts) {
        json["parts"].push_back({{"name", part.name},
                                 {"material", part.material},
                                 {"law", law_json(part.scattering)},
                                 {"coherent", coherent_json(part.scattering)}});
      }
      break;
    case InstanceKind::point_target:
      json["kind"] = "point_target";
      json["target_strength_db"] = number_or_null(instance.target_strength_db);
      break;
    case InstanceKind::volume:
      json["kind"] = "volume";
      json["strength_db"] = instance.volume_strength_db;
      break;
  }
  return json;
}

}  // namespace ensonify
