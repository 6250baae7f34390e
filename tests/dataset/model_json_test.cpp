#include "dataset/model_json.h"

#include "catch.h"
#include "core/units.h"
#include "dataset/sample.h"
#include "dataset/sequence_json.h"

using namespace ensonify;

namespace {

std::string words(const SequenceInfo& info, const char* key) {
  return model_json(info)[key].get<std::string>();
}

Instance surface(const Material& material) {
  Instance instance;
  instance.scattering = material;
  return instance;
}

}  // namespace

// Protects the words of the model: they have to change with the sonar they describe.
TEST_CASE("the model describes the normalization in use") {
  auto info = sample::sequence_info(0);
  CHECK(words(info, "beam_normalization") == "N_j = 1");
  info.sonar.normalization = Normalization::mean_square;
  CHECK(words(info, "beam_normalization").starts_with("N_j = sqrt("));
  info.noise_power_pa2 = 0;
  CHECK(sequence_head(info, {}, 0)["noise"].is_null());
}

TEST_CASE("the model speaks of motion where there is any") {
  SequenceInfo info = sample::sequence_info(0);
  CHECK_FALSE(model_json(info).contains("motion"));
  info.motion_within_ping = true;
  CHECK(model_json(info)["motion"].get<std::string>().find("tau_i later") != std::string::npos);
}

TEST_CASE("the model describes pulse and window") {
  auto info = sample::sequence_info(0);
  CHECK(words(info, "pulse_spectrum").starts_with("W(d) = exp("));
  CHECK(sonar_json(info)["pulse"] == Json({{"shape", "gaussian"}}));
  info.sonar.pulse = {PulseShape::lfm, 1e-3, 0.25, {}};
  CHECK(words(info, "pulse_spectrum").starts_with("W(d) = T(d); T(d) = 1 for |d| <= (0.5 - e) b"));
  CHECK(sonar_json(info)["pulse"] ==
        Json({{"shape", "lfm"}, {"duration_s", 1e-3}, {"taper", 0.25}}));
  info.sonar.pulse = {PulseShape::cw, 1e-3, 0.1, {}};
  info.sonar.window = Window::hann;
  CHECK(words(info, "pulse_spectrum").find("T(d) (1 + cos(2 pi d/b))/2;") != std::string::npos);
  info.sonar.pulse = {PulseShape::table, 0, 0.1, {{9e5, 1, 0.5}, {9.1e5, 2, -0.5}}};
  CHECK(sonar_json(info)["pulse"]["rows"] == Json({{9e5, 1, 0.5}, {9.1e5, 2, -0.5}}));
}

TEST_CASE("the model describes the beams and the converter") {
  auto info = sample::sequence_info(0);
  info.receive_aperture_wavelengths = 70;
  CHECK(sonar_json(info)["beams"]["shading"] ==
        Json({{"kind", "uniform"}, {"aperture_wavelengths", 70.0}}));
  CHECK(sonar_json(info)["beams"]["transmit_width_rad"].is_null());
  CHECK(sonar_json(info)["adc"].is_null());
  info.sonar.shading = {Shading::taylor, -40, 6};
  info.sonar.transmit_width_rad = 1.5;
  info.sonar.adc = Adc{12, 180};
  const Json sonar = sonar_json(info);
  CHECK(sonar["beams"]["shading"]["side_lobe_db"] == -40);
  CHECK(sonar["beams"]["shading"]["nbar"] == 6);
  CHECK(sonar["beams"]["transmit_width_rad"] == 1.5);
  // Full scale 1000 Pa over 2^11 steps.
  CHECK(sonar["adc"]["step_pa"].get<double>() == Approx(1000.0 / 2048));
  CHECK(words(info, "beam_pattern").find("prod_{n=1}") != std::string::npos);
  info.sonar.shading.kind = Shading::chebyshev;
  CHECK(words(info, "beam_pattern").find("cosh") != std::string::npos);
}

// Protects readers of an array's data: every number of every element, and its own formulas; nothing
// new in a data set of beams.
TEST_CASE("the model describes an array") {
  auto info = sample::sequence_info(0);
  CHECK_FALSE(sonar_json(info).contains("receiver"));
  ArrayReceiver& array = info.sonar.array.emplace();
  array.elements = 2;
  array.spacing_m = 0.1;
  array.shading = {Shading::taylor, -30, 4};
  array.response = {{1, 0.5}, 0};
  info.element_y_m = {-0.05, 0.05};
  info.element_weight = {0.5, 0.5};
  const Json receiver = sonar_json(info)["receiver"];
  CHECK(receiver["elements"] == 2);
  CHECK(receiver["y_m"] == Json({-0.05, 0.05}));
  CHECK(receiver["response_re"] == Json({1.0, 0.0}));
  CHECK(receiver["response_im"] == Json({0.5, 0.0}));
  CHECK(receiver["shading"]["nbar"] == 4);
  CHECK(words(info, "series").find("(D_nj + F_njk)) p_n(t_k + D_nj)") != std::string::npos);
  CHECK(words(info, "beam_pattern") == "E(u) = 1");
  array.focus = Focus::none;
  array.steering = Steering::phase;
  array.element_width_m = 0.01;
  CHECK(words(info, "series").find("D_nj) p_n(t_k)") != std::string::npos);
  CHECK_FALSE(model_json(info)["symbols"].contains("F_njk"));
  CHECK(words(info, "beam_pattern").starts_with("E(u) = sin(pi v)/(pi v)"));
}

// Protects readers that work levels out again: each instance says how it throws back.
TEST_CASE("an instance tells its law") {
  Material material;
  material.reflectivity = 1e-3;
  material.lambert_exponent = 2;
  CHECK(instance_json(surface(material))["law"] ==
        Json({{"model", "lambert"}, {"reflectivity", 1e-3}, {"exponent", 2.0}}));
  CHECK(instance_json(surface(material))["coherent"].is_null());
  material.law = ScatteringLaw::lommel_seeliger;
  material.coherent = CoherentModel::rician;
  material.rician_k = 0.5;
  CHECK(instance_json(surface(material))["law"]["model"] == "lommel_seeliger");
  CHECK(instance_json(surface(material))["coherent"] == Json({{"model", "rician"}, {"k", 0.5}}));
  material.law = ScatteringLaw::table;
  material.table = {{0, kPi / 2}, {-40, -10}};
  material.coherent = CoherentModel::kirchhoff;
  material.reflection = -0.5;
  material.roughness_rms_m = 1e-4;
  const Json json = instance_json(surface(material));
  CHECK(json["law"]["rows"] == Json({{0.0, -40.0}, {90.0, -10.0}}));
  CHECK(json["coherent"]["reflection"] == -0.5);
  CHECK(json["coherent"]["roughness_rms_m"] == 1e-4);
}

TEST_CASE("a volume tells its strength") {
  Instance instance;
  instance.kind = InstanceKind::volume;
  instance.volume_strength_db = -60;
  CHECK(instance_json(instance)["kind"] == "volume");
  CHECK(instance_json(instance)["strength_db"] == -60);
}

// Protects whoever works the laws out again: a part's own law stands beside the object's.
TEST_CASE("parts of an instance say how they scatter") {
  Instance instance = surface({.reflectivity = 1e-3});
  CHECK_FALSE(instance_json(instance).contains("parts"));
  Material steel{.law = ScatteringLaw::lommel_seeliger, .reflectivity = 0.5};
  steel.coherent = CoherentModel::rician;
  steel.rician_k = 2;
  instance.parts = {{"mast", "steel", steel}};
  CHECK(instance_json(instance)["parts"] ==
        Json::array({{{"name", "mast"},
                      {"material", "steel"},
                      {"law", {{"model", "lommel_seeliger"}, {"reflectivity", 0.5}}},
                      {"coherent", {{"model", "rician"}, {"k", 2.0}}}}}));
}
