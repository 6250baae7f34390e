// The keys of materials: diffuse scattering and the coherent part.
#include <cmath>

#include "scenario/sections.h"

namespace ensonify {
namespace {

constexpr NumberRange kReflectivity = from_to(0, 1e6);
constexpr NumberRange kBackscatterStrengthDb = from_to(-200, 60);

// A material has one of these keys, or a table, which states the strength itself. A law that cannot
// be read may have been a table, so then neither key is required.
void reflectivity_fields(Fields& f, MaterialSpec& material) {
  constexpr std::string_view kKeys[] = {"reflectivity", "backscatter_strength_db"};
  const auto law = f.peek_kind("law", material.law.kind, ScatteringLaw::table);
  const bool is_table = law == ScatteringLaw::table;
  const Rule rule = useless_if(
      is_table, "with a table, which states the strength itself; expected only one of them",
      {.has_default = false});
  std::optional<std::size_t> which;
  if (!is_table) {
    which = f.only_key(kKeys, 0,
                       "either reflectivity, or backscatter_strength_db, which is 10 log10 of it",
                       law ? Need::required : Need::optional);
  }
  if (which == 0u || is_table) {
    f.number({kKeys[0], "Reflectivity",
              "μ, the surface backscattering coefficient at normal incidence, from which law gives "
              "it at other angles; 0 is black: the surface casts a shadow and has no echo",
              "sr⁻¹"},
             material.reflectivity, kReflectivity, rule);
  }
  if (which == 1u || is_table) {
    double strength_db = 0;
    if (f.number(
            {kKeys[1], "Backscattering strength", "10 log10 of the reflectivity, in place of it"},
            strength_db, kBackscatterStrengthDb, rule)) {
      material.reflectivity = std::pow(10.0, strength_db / 10);
    }
  }
}

// In the order of ScatteringLaw.
constexpr KindText kLawTexts[] = {
    {"Lambert", "Backscattering coefficient μ cosⁿ⁺¹(α) at the angle of incidence α"},
    {"Lommel-Seeliger", "Backscattering coefficient μ cos(α) at the angle of incidence α"},
    {"Measured strength", "Backscattering strength from a table, linear in dB between rows"},
};

void law_fields(Fields& f, LawSpec& law) {
  if (!f.begin_kind({"law", "Scattering law", "How the backscattering depends on the angle"},
                    law.kind, ScatteringLaw::table, kLawTexts)) {
    return;
  }
  if (law.kind == ScatteringLaw::lambert) {
    f.number({"exponent", "Exponent", "n; left out: the value of scattering.lambert_exponent"},
             law.exponent, kLambertExponent);
  }
  if (law.kind == ScatteringLaw::table) {
    f.file({"file", "Strength file", "CSV file with the columns grazing_deg and strength_db"},
           law.file, {".csv"}, kRequired);
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
  const bool known =
      f.word(
          {"model", "Model",
           "rician: a constant part of each echo; kirchhoff: specular echoes of a smooth surface"},
          kModels, model, kRequired) ||
      f.writing();
  const bool is_rician = known && model == 0, is_kirchhoff = known && model == 1;
  const Rule of_kirchhoff = useless_if(is_rician, "with model rician; expected model kirchhoff");
  f.number({"k", "K factor",
            "Of rician: power of the constant part divided by that of the random part; needed with "
            "rician"},
           rician.k, from_to(0, 1e6),
           useless_if(is_kirchhoff, "with model kirchhoff; expected model rician",
                      {.need = is_rician ? Need::required : Need::optional, .has_default = false}));
  f.number(
      {"reflection", "Reflection coefficient", "Of kirchhoff: amplitude reflection coefficient"},
      kirchhoff.reflection, from_to(-1, 1), of_kirchhoff);
  f.number({"roughness_rms_m", "Roughness",
            "Of kirchhoff: rms height of the surface, which reduces the reflection coefficient"},
           kirchhoff.roughness_rms_m, from_to(0, 1), of_kirchhoff);
  if (is_rician) coherent = rician;
  if (is_kirchhoff) coherent = kirchhoff;
}

}  // namespace

void fields(Fields& f, MaterialSpec& material) {
  reflectivity_fields(f, material);
  law_fields(f, material.law);
  const bool has_part = !std::holds_alternative<std::monostate>(material.coherent);
  if (f.begin({"coherent", "Coherent part", "Part of the echo that is not random; left out: none"},
              written_if(has_part, {.has_default = false}))) {
    coherent_fields(f, material.coherent);
    f.end();
  }
}

Material material_of(const MaterialSpec& spec, const ScatteringSpec& scattering) {
  Material material;
  material.reflectivity = spec.reflectivity;
  material.lambert_exponent = scattering.lambert_exponent;
  material.law = spec.law.kind;
  if (spec.law.exponent) material.lambert_exponent = *spec.law.exponent;
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
