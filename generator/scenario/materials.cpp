// Materials: how surfaces scatter at random, and what they throw back in phase.
#include "scenario/sections.h"

namespace ensonify {
namespace {

constexpr std::string_view kLaws[] = {"lambert", "lommel_seeliger", "table"};

// A table holds the strength itself; a law that cannot be read may have been a table.
Rule reflectivity_rule(Fields& f, const MaterialSpec& material) {
  const auto law = f.peek_kind("law", kLaws, material.law.index());
  return useless_if(law == 2u,
                    "beside a table, which holds the strength itself; accepted is either alone",
                    {.need = law ? Need::required : Need::optional});
}

void law_fields(Fields& f, LawSpec& law) {
  std::size_t index = law.index();
  if (!f.begin_kind("law", kLaws, index)) return;
  if (index == 0) {
    if (!f.writing()) law = LambertSpec{};
    f.number("exponent", std::get<LambertSpec>(law).exponent, kLambertExponent);
  } else if (index == 1) {
    law = LommelSeeligerSpec{};
  } else {
    if (!f.writing()) law = BackscatterTableSpec{};
    f.file("file", std::get<BackscatterTableSpec>(law).file, {".csv"}, kRequired);
  }
  f.end();
}

void coherent_fields(Fields& f, CoherentSpec& coherent) {
  constexpr std::string_view kModels[] = {"rician", "kirchhoff"};
  auto* given_rician = std::get_if<RicianSpec>(&coherent);
  auto* given_kirchhoff = std::get_if<KirchhoffSpec>(&coherent);
  RicianSpec rician = given_rician != nullptr ? *given_rician : RicianSpec{};
  KirchhoffSpec kirchhoff = given_kirchhoff != nullptr ? *given_kirchhoff : KirchhoffSpec{};
  std::size_t model = given_kirchhoff != nullptr ? 1 : 0;
  const bool known = f.word("model", kModels, model, kRequired) || f.writing();
  const bool is_rician = known && model == 0, is_kirchhoff = known && model == 1;
  const Rule of_kirchhoff = useless_if(is_rician, "in the model rician, accepted with kirchhoff");
  f.number("k", rician.k, from_to(0, 1e6),
           useless_if(is_kirchhoff, "in the model kirchhoff, accepted with rician",
                      {.need = is_rician ? Need::required : Need::optional}));
  f.number("reflection", kirchhoff.reflection, from_to(-1, 1), of_kirchhoff);
  f.number("roughness_rms_m", kirchhoff.roughness_rms_m, from_to(0, 1), of_kirchhoff);
  if (is_rician) coherent = rician;
  if (is_kirchhoff) coherent = kirchhoff;
}

}  // namespace

void fields(Fields& f, MaterialSpec& material) {
  f.number("reflectivity", material.reflectivity, from_to(0, 1e6), reflectivity_rule(f, material));
  law_fields(f, material.law);
  const bool has_part = !std::holds_alternative<std::monostate>(material.coherent);
  if (f.begin("coherent", written_if(has_part))) {
    coherent_fields(f, material.coherent);
    f.end();
  }
}

Material material_of(const MaterialSpec& spec, const ScatteringSpec& scattering) {
  Material material;
  material.reflectivity = spec.reflectivity;
  material.lambert_exponent = scattering.lambert_exponent;
  if (const auto* lambert = std::get_if<LambertSpec>(&spec.law)) {
    if (lambert->exponent) material.lambert_exponent = *lambert->exponent;
  } else if (std::holds_alternative<LommelSeeligerSpec>(spec.law)) {
    material.law = ScatteringLaw::lommel_seeliger;
  } else {
    material.law = ScatteringLaw::table;
  }
  if (const auto* rician = std::get_if<RicianSpec>(&spec.coherent)) {
    material.coherent = CoherentModel::rician;
    material.rician_k = rician->k;
  } else if (const auto* kirchhoff = std::get_if<KirchhoffSpec>(&spec.coherent)) {
    material.coherent = CoherentModel::kirchhoff;
    material.reflection = kirchhoff->reflection;
    material.roughness_rms_m = kirchhoff->roughness_rms_m;
  }
  return material;
}

}  // namespace ensonify
