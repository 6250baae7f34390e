#include "dataset/array_json.h"

#include <string>

namespace ensonify {
namespace {

Json shading_json(const BeamShading& shading) {
  Json json = {{"kind", name_of(shading.kind)}};
  if (shading.kind == Shading::taylor || shading.kind == Shading::chebyshev) {
    json["side_lobe_db"] = shading.side_lobe_db;
  }
  if (shading.kind == Shading::taylor) json["nbar"] = shading.nbar;
  return json;
}

std::string series_formula(const ArrayReceiver& array) {
  const bool focused = array.focus == Focus::dynamic;
  const bool delayed = array.steering == Steering::true_delay;
  return std::string(
             "p_n(t) = response_n sum_i E(u_i) a_i gain_i S0 exp(-i 2 pi f_c (tau_i + delta_ni)) "
             "s(t - tau_i - delta_ni) of element n, plus the echoes of instances of kind volume, "
             "plus noise where `noise` is not null; p_j(t_k) = sum_n weight_n exp(i 2 pi f_c ") +
         (focused ? "(D_nj + F_njk)) p_n(" : "D_nj) p_n(") + (delayed ? "t_k + D_nj)" : "t_k)") +
         "; then quantised where sonar.adc is not null";
}

}  // namespace

Json receiver_json(const SequenceInfo& info) {
  const ArrayReceiver& array = *info.sonar.array;
  Json re = Json::array(), im = Json::array();
  for (const std::complex<double>& response : array.response) {
    re.push_back(response.real());
    im.push_back(response.imag());
  }
  return {{"mode", "array"},
          {"elements", array.elements},
          {"spacing_m", array.spacing_m},
          {"element_width_m", array.element_width_m},
          {"shading", shading_json(array.shading)},
          {"focus", name_of(array.focus)},
          {"steering", name_of(array.steering)},
          {"y_m", info.element_y_m},
          {"weight", info.element_weight},
          {"response_re", std::move(re)},
          {"response_im", std::move(im)}};
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
      "from the sonar, for path > 0 that of their image in the mirrors of paths[path].back; with "
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

}  // namespace ensonify
