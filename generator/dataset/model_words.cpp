#include "dataset/manifest_members.h"

#include <string>
#include <string_view>

namespace ensonify {
namespace {

// The formula of the pattern `name`, such as B(theta).
std::string pattern_formula(const std::string& name, Shading shading) {
  switch (shading) {
    case Shading::uniform:
      return name + " = sin(pi u)/(pi u); B(0) = 1";
    case Shading::hann:
      return name + " = sin(pi u)/(pi u) / (1 - u^2); B(0) = 1";
    case Shading::taylor:
      return name +
             " = sin(pi u)/(pi u) prod_{n=1}^{nbar-1} (1 - u^2/(sigma^2 (A^2 + (n - "
             "1/2)^2))) / (1 - u^2/n^2), sigma = nbar/sqrt(A^2 + (nbar - 1/2)^2), cosh(pi A) = "
             "10^(-side_lobe_db/20)";
    case Shading::chebyshev:
      return name + " = cos(pi sqrt(u^2 - A^2))/cosh(pi A), cosh(pi A) = 10^(-side_lobe_db/20)";
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

std::string replaced(std::string text, std::string_view before, std::string_view after) {
  const std::size_t at = text.find(before);
  return at == std::string::npos ? text : text.replace(at, before.size(), after);
}

std::string series_formula(const ArrayReceiver& array) {
  const bool focused = array.focus == Focus::dynamic;
  const bool delayed = array.steering == Steering::true_delay;
  return std::string(
             "p_n(t) = response_n sum_i E(u_i) a_i gain_i S0 exp(-i 2 pi f_c (tau_i + delta_ni)) "
             "s(t - tau_i - delta_ni) of element n, plus the echoes of instances of kind volume, "
             "plus noise where `noise` is not null; p_j(t_k) = sum_n weight_n exp(i 2 pi f_c ") +
         (focused ? "(D_nj + F_njk)) p_n(" : "D_nj) p_n(") + (delayed ? "t_k + D_nj)" : "t_k)") +
         "; then quantized where sonar.adc is not null";
}

// Middles of beam cells, and widths, where they do not follow from those of one beam.
void set_unequal_beams(const Sonar& sonar, Json& model) {
  Json& symbols = model["symbols"];
  if (!sonar.azimuth_rad.empty()) {
    model["series"] = replaced(model["series"].get<std::string>(), "theta_beam(i)", "phi_beam(i)");
    model["beam_normalization"] =
        replaced(model["beam_normalization"].get<std::string>(), "theta_i", "phi_i");
    symbols["phi_i"] =
        "the middle of beam cell i, whose borders are halfway between azimuth_rad.npy[i] and its "
        "neighbors, and as far beyond the outer beams as their other borders";
  }
  if (!sonar.width_rad.empty()) {
    symbols["u"] =
        "sonar.beams.shading.aperture_wavelengths sonar.beams.width_rad / "
        "sonar.beams.widths_rad[j] sin(theta)";
  }
}

void set_array_model(const SequenceInfo& info, Json& model) {
  const ArrayReceiver& array = *info.sonar.array;
  model["series"] = series_formula(array);
  Json& symbols = model["symbols"];
  symbols.erase("t_n");
  symbols.erase("beam(i)");
  symbols["t_k"] = "k / b, k = 0 ... N-1";
  symbols["c"] = "water.sound_speed_m_s";
  symbols["y_n"] = "sonar.receiver.y_m[n]";
  symbols["response_n"] = "sonar.receiver.response_re[n] + i response_im[n]";
  symbols["weight_n"] = "sonar.receiver.weight[n]";
  symbols["x_i"] =
      "q_i (cos el cos az, cos el sin az, sin el), az and el being scatterers azimuth_rad and "
      "elevation_rad; q_i is the length of the received path: the distance of scatterers x, y, z "
      "from the sonar, for path > 0 that of their image in the reflectors of paths[path].back; "
      "with "
      "water.profile their horizontal distance over the cosine of the arrival's elevation above "
      "the horizontal";
  symbols["delta_ni"] = "(|x_i - (0, y_n, 0)| - |x_i|) / c";
  symbols["u_i"] = "cos el sin az";
  symbols.erase("u");
  symbols["D_nj"] = "-y_n sin(theta_j) / c";
  if (array.focus == Focus::dynamic) {
    symbols["F_njk"] =
        "(|r_k (cos theta_j, sin theta_j, 0) - (0, y_n, 0)| - r_k) / c - D_nj, r_k = max(k, 1) "
        "c / (2b)";
  }
  model["beam_pattern"] =
      array.element_width_m > 0
          ? "E(u) = sin(pi v)/(pi v), v = sonar.receiver.element_width_m u f_c / c; E(0) = 1"
          : "E(u) = 1";
  model["beam_normalization"] = "sum of weight_n = 1";
}

constexpr const char* kMotion =
    "poses are those at transmission; the sonar receives scatterer i where it is tau_i later, and "
    "moving objects scatter sound where they are then. With eta_i = scatterers doppler, s(t - "
    "tau_i) "
    "is replaced by the pulse of the spectrum P(d') R(d) / (1 + eta_i), d' = (d - eta_i "
    "f_c)/(1 + eta_i), scaled as s is; P is the transmitted pulse, R the receiver's window and "
    "band";

constexpr const char* kTransmit =
    "B(theta_beam(i) - theta_j) is multiplied by T(theta_beam(i) - theta_k), k being the beam with "
    "k = j modulo sonar.transmit.groups whose azimuth is nearest to theta_beam(i); T(theta) = "
    "sin(pi v)/(pi v), T(0) = 1, v = 0.884 sin(theta)/w with the -3 dB width w, which is "
    "sonar.transmit.width_rad or, if this is null, the width of beam k. Sound and samples of beam "
    "j count from sonar.transmit.after_s[j modulo sonar.transmit.groups] after the ping";
constexpr const char* kSectors =
    "; in place of j modulo sonar.transmit.groups, the group of a beam is the sector of "
    "sonar.transmit.sector_beams that has it";
constexpr const char* kCarriers =
    "; f_c is the sonar.transmit.frequency_hz of the group of beam j, and gain_i, which has the "
    "absorption of the group of beam(i), gets that of the group of beam j "
    "(water.group_absorption_db_m)";

}  // namespace

Json model_json(const SequenceInfo& info) {
  const Sonar& sonar = info.sonar;
  const bool calibrated = sonar.normalization == Normalization::calibrated;
  Json json = {
      {"series",
       "p_j(t_n) = S0 sum_i B(theta_beam(i) - theta_j)/N_j a_i gain_i exp(-i 2 pi f_c tau_i) "
       "s(t_n - tau_i); plus the echoes of instances of kind volume; plus noise where `noise` is "
       "not null; then quantized where sonar.adc is not null"},
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
      {"beam_pattern", pattern_formula("B(theta)", sonar.shading.kind)},
      {"elevation_pattern",
       pattern_formula("B(elevation_rad)", sonar.elevation_line.shading.kind) +
           ", u = sonar.elevation.shading.aperture_wavelengths sin(elevation_rad); two-way; where "
           "the scatterer's sound departs and arrives in different directions, the geometric mean "
           "of both"},
      {"beam_normalization",
       calibrated ? "N_j = 1" : "N_j = sqrt(sum over beams i of B(theta_i - theta_j)^2)"},
      {"pulse",
       "s(t) = S(t)/max|S|, S(t) = sum_m W(d_m) exp(i 2 pi d_m t), d_m = (m - M/2) b/M, m = 0 ... "
       "M-1, the maximum over t = k/(32 b); the record is one period of it, t modulo M/b"},
      {"pulse_spectrum", spectrum_formula(sonar.pulse, sonar.window)}};
  if (sonar.array) {
    set_array_model(info, json);
  } else {
    set_unequal_beams(sonar, json);
  }
  if (group_count(sonar) > 1) {
    json["transmit"] = std::string(kTransmit) +
                       (sonar.transmit->sector_beams.empty() ? "" : kSectors) +
                       (sonar.transmit->frequency_hz.empty() ? "" : kCarriers);
  }
  if (info.motion_within_ping) json["motion"] = kMotion;
  return json;
}

Json axes_json(const SequenceInfo& info) {
  const OutputSelection& output = info.output;
  if (!is_sonar(info)) {
    return {{"frames",
             "world: x east, y north, z up; quaternions w, x, y, z turn the instrument's "
             "frame into world"}};
  }
  Json axes = {{"timeseries", "complex64 [beams, samples], Pa (rms), complex baseband"},
               {"polar", "rows: samples, nearest first; columns: beams, 0 first"},
               {"cartesian", "the fan from above: boresight up, port left; nearest neighbor"},
               {"first_return_m", "float32 [pings, beams], NaN: none"},
               {"level", "20 log10|p| + 120, dB re 1 uPa; -99 where there is no energy"},
               {"frames",
                "world: x east, y north, z up; sonar: x along the boresight, y to port, z up; "
                "quaternions w, x, y, z turn sonar into world"}};
  if (info.sonar.detector) {
    axes["level"] =
        "law^-1(mean over sonar.detector.integrate samples of law(P 10^(noise/10))) + 120, P = "
        "sum_k "
        "|p_k|^2 + floor, p_k in sub-band k of sonar.detector.looks, law 10 log10 P, or P or "
        "sqrt(P) "
        "in dB; dB re 1 uPa; -99 where there is no energy";
    if (info.sonar.detector->bands > 1) {
      axes["level"] = axes["level"].get<std::string>() +
                      "; P is the mean over sonar.detector.bands bands, of which the time series "
                      "has the first";
    }
  }
  if (output.layers) {
    axes["layers"] = "complex64 [beams, samples], Pa (rms); their sum is the time series";
  }
  if (output.channels) {
    axes["channels"] =
        "complex64 [elements, samples], Pa (rms): p_n(t) of model.series, noise included, before "
        "any ADC; elements by rising y";
  }
  if (output.front) {
    axes["front"] =
        "rows: elevations of rays, lowest first; columns: azimuths, beam 0 first; the surface that "
        "each ray meets first: slant range, unit normal (sonar frame), 10 log10 of the backscatter "
        "per unit of surface; NaN and 0: none";
  }
  if (output.timeseries_exr) {
    axes["timeseries_exr"] = "rows: samples, columns: beams; float channels p.re, p.im, Pa (rms)";
  }
  return axes;
}

std::string grey_formula(const Display& display, const char* absorption) {
  std::string text = "shown = Y + tvg.spreading log10(r)";
  if (display.absorption) text += std::string(" + 2 ") + absorption + " r";
  text += " + gain_db, r the sample's range in meters, for sample 0 that of sample 1";
  if (display.automatic_gain) {
    text +=
        ", plus the gain that puts the level at rank 0.995 (n - 1), rounded down, of the ping's "
        "n pixels with energy on db[1] where gain_db is 0";
  }
  text += display.scale == GreyScale::db ? "; gray = 255 (shown - db[0]) / (db[1] - db[0])"
                                         : "; gray = 255 10^(gamma (shown - db[1]) / 20)";
  text += ", rounded, 0 to 255; 0 where Y = -99; ";
  return text + (display.resampling == Resampling::nearest
                     ? "Cartesian images show the nearest polar pixel"
                     : "in Cartesian images, Y is 10 log10 of the mean of 10^(Y / 10) over the "
                       "footprint of the pixel and r is the range of its center");
}

}  // namespace ensonify
