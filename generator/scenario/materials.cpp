// The keys of materials: diffuse scattering and the coherent part.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/part_keys.h"
#include "scenario/known_materials.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

constexpr NumberRange kReflectivity = from_to(0, 1e6);
constexpr NumberRange kBackscatterStrengthDb = from_to(-200, 60);

// A material has one of these keys, or a table, which states the strength itself. A law that cannot
// be read may have been a table, so then neither key is required.
void reflectivity_fields(Fields& f, MaterialSpec& material) {
  constexpr std::string_view kKeys[] = {"reflectivity", "backscatter_strength_db"};
  const auto law = f.peek_kind("law", kLawWords, material.law.index());
  const bool is_table = law && states_strength(law_at(*law));
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

constexpr auto kLawTexts = of_laws([](auto law) {
  using Law = typename decltype(law)::type;
  return KindText{Law::kText.title, Law::kText.meaning};
});

void law_fields(Fields& f, ScatteringLaw& law) {
  std::size_t index = law.index();
  if (!f.begin_kind({"law", "Scattering law", "How the backscattering depends on the angle"},
                    kLawWords, kLawTexts, index)) {
    return;
  }
  if (!f.writing()) law = law_at(index);
  std::visit(
      [&]<class Law>(Law& values) {
        for (const LawParameter<Law>& p : Law::parameters()) {
          f.number({p.key, p.title, p.meaning}, values.*p.value, from_to(p.least, p.most),
                   {.need = p.need});
        }
        if constexpr (requires { values.file; }) {
          f.file({"file", "Strength file", "CSV file with the columns grazing_deg and strength_db"},
                 values.file, {".csv"}, kRequired);
        }
      },
      law);
  f.end();
}

void coherent_fields(Fields& f, CoherentSpec& coherent, bool has_wall) {
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
  const Rule of_reflection =
      has_wall ? useless_if(true, "with a wall, whose reflection follows from its own keys",
                            written_if(false))
               : of_kirchhoff;
  const Rule of_surface =
      has_wall
          ? useless_if(true, "with a wall, whose echo follows from its own keys", written_if(false))
          : of_kirchhoff;
  f.number({"k", "K factor",
            "Of rician: power of the constant part divided by that of the random part; needed with "
            "rician"},
           rician.k, from_to(0, 1e6),
           useless_if(is_kirchhoff, "with model kirchhoff; expected model rician",
                      {.need = is_rician ? Need::required : Need::optional, .has_default = false}));
  f.number(
      {"reflection", "Reflection coefficient", "Of kirchhoff: amplitude reflection coefficient"},
      kirchhoff.reflection, from_to(-1, 1), of_reflection);
  f.number({"roughness_rms_m", "Roughness",
            "Of kirchhoff: rms height of the surface, which reduces the reflection coefficient"},
           kirchhoff.roughness_rms_m, from_to(0, 1), of_kirchhoff);
  const bool scatters = f.number(
      {"roughness_correlation_m", "Correlation length of the roughness",
       "Of kirchhoff: distance over which the heights decorrelate to 1/e, from which the energy "
       "that roughness takes from the specular echo scatters; at least roughness_rms_m; left out: "
       "it is lost"},
      kirchhoff.roughness_correlation_m, from_to(1e-5, 10), of_surface);
  if (scatters && *kirchhoff.roughness_correlation_m < kirchhoff.roughness_rms_m) {
    f.fault("roughness_correlation_m",
            fmt::format("{} is below the roughness of {}, so that slopes are too steep for the "
                        "model; expected at least roughness_rms_m",
                        *kirchhoff.roughness_correlation_m, kirchhoff.roughness_rms_m));
  }
  f.boolean(
      {"edges", "Edges", "Of kirchhoff: sharp edges diffract as those of a rigid or soft wedge"},
      kirchhoff.edges, written_if(kirchhoff.edges, of_surface));
  if (is_rician) coherent = rician;
  if (is_kirchhoff) coherent = kirchhoff;
}

constexpr NumberRange kFieldCorrelation = from_to(1e-3, 1e3);

constexpr TextureWords kTextureWords = {
    "Distribution of the factor on the reflectivity, whose mean is 1: gamma or lognormal",
    "Distance over which the field decorrelates to 1/e, in the coordinates of the object"};

}  // namespace

void texture_fields(Fields& f, SurfaceTexture& texture, const TextureWords& words) {
  constexpr std::string_view kModels[] = {"gamma", "lognormal"};
  std::size_t model = texture.model == TextureModel::lognormal ? 1 : 0;
  const bool known =
      f.word({"model", "Model", words.model}, kModels, model, kRequired) || f.writing();
  const bool is_gamma = known && model == 0, is_lognormal = known && model == 1;
  f.number(
      {"shape", "Shape",
       "Of gamma: ν, where the relative variance is 1/ν; speckle then has a K distribution; needed "
       "with gamma"},
      texture.shape, from_to(0.05, 1e4),
      useless_if(is_lognormal, "with model lognormal; expected spread_db",
                 {.need = is_gamma ? Need::required : Need::optional, .has_default = false}));
  f.number(
      {"spread_db", "Spread",
       "Of lognormal: standard deviation of the level; needed with lognormal", "dB"},
      texture.spread_db, from_to(0, words.widest_spread_db),
      useless_if(is_gamma, "with model gamma; expected shape",
                 {.need = is_lognormal ? Need::required : Need::optional, .has_default = false}));
  f.number({"correlation_m", "Correlation length", words.correlation}, texture.correlation_m,
           from_to(words.shortest_m, 1e3), kRequired);
  if (is_gamma) texture.model = TextureModel::gamma;
  if (is_lognormal) texture.model = TextureModel::lognormal;
}

namespace {

void wall_fields(Fields& f, Wall& wall) {
  constexpr std::string_view kFilling[] = {"water", "air"};
  wall_keys(f, wall);
  std::size_t filling = wall.water_inside ? 0 : 1;
  f.word({"filling", "Filling",
          "What is behind the wall: water, which carries the sound on, or air, which reflects it"},
         kFilling, filling);
  wall.water_inside = filling == 0;
  if (wall.speed_m_s > 0) check_solid(f, wall.speed_m_s, wall.shear_speed_m_s);
}

void growth_fields(Fields& f, GrowthSpec& growth) {
  f.text({"material", "Material", "A key of materials: what has grown on the surface"},
         growth.material, kRequired);
  f.number({"cover", "Cover", "Mean share of the surface that it covers"}, growth.cover,
           from_to(0, 1), kRequired);
  f.number({"correlation_m", "Correlation length",
            "Distance over which the field decorrelates to 1/e; patches are about twice as large"},
           growth.correlation_m, kFieldCorrelation, kRequired);
}

}  // namespace

void check_solid(Fields& f, double speed_m_s, double shear_speed_m_s) {
  const double most_m_s = std::sqrt(0.75) * speed_m_s;
  if (shear_speed_m_s < most_m_s) return;
  f.fault(
      "shear_speed_m_s",
      fmt::format("{} is too fast for a speed_m_s of {}; expected less than {:.6g}, so that the "
                  "material resists compression",
                  shear_speed_m_s, speed_m_s, most_m_s));
}

void check_growth(Fields& f, const std::vector<MaterialSpec>& materials) {
  for (const MaterialSpec& spec : materials) {
    if (!spec.growth) continue;
    const auto named = [&](const MaterialSpec& other) {
      return other.name == spec.growth->material;
    };
    if (std::any_of(materials.begin(), materials.end(), named) &&
        spec.growth->material != spec.name) {
      continue;
    }
    f.fault("materials", fmt::format("{}.growth.material: {} is not another material; expected the "
                                     "name of one",
                                     spec.name, shown(spec.growth->material)));
  }
}

void fields(Fields& f, MaterialSpec& material) {
  const std::vector<std::string> known = known_materials();
  const std::vector<std::string_view> names(known.begin(), known.end());
  std::size_t preset = 0;
  f.word(
      {"preset", "Preset",
       "Built-in material whose keys the other keys override; `ensonify presets materials` prints "
       "them all. A material that is used but not listed is the preset of its name; left out: "
       "none"},
      names, preset, written_if(false, {.has_default = false}));
  reflectivity_fields(f, material);
  f.numbers(
      {"color", "Color",
       "Share of the light that the surface reflects, red, green and blue, for a camera", "1"},
      material.color, from_to(0, 1), written_if(material.color != MaterialSpec{}.color));
  law_fields(f, material.law);
  const bool has_wall = f.writing() ? material.wall.has_value() : f.peek("wall") != nullptr;
  const bool has_part = !std::holds_alternative<std::monostate>(material.coherent);
  if (f.begin({"coherent", "Coherent part", "Part of the echo that is not random; left out: none"},
              written_if(has_part, {.has_default = false}))) {
    coherent_fields(f, material.coherent, has_wall);
    f.end();
  }
  if (f.begin({"wall", "Wall",
               "The surface is a thin wall that sound passes through, and what is inside echoes as "
               "well; left out: nothing is behind the surface"},
              written_if(has_wall, {.has_default = false}))) {
    if (!material.wall) material.wall.emplace();
    wall_fields(f, *material.wall);
    f.end();
  }
  if (f.begin({"texture", "Texture",
               "Random variation of the reflectivity over the surface, fixed to the object; left "
               "out: none"},
              written_if(material.texture.has_value(), {.has_default = false}))) {
    if (!material.texture) material.texture.emplace();
    texture_fields(f, *material.texture, kTextureWords);
    f.end();
  }
  if (f.begin({"growth", "Growth",
               "Patches of the surface that have another material, fixed to the object; left out: "
               "none"},
              written_if(material.growth.has_value(), {.has_default = false}))) {
    if (!material.growth) material.growth.emplace();
    growth_fields(f, *material.growth);
    f.end();
  }
}

bool has_walls(const Scenario& scenario) {
  return std::ranges::any_of(scenario.materials,
                             [](const MaterialSpec& spec) { return spec.wall.has_value(); });
}

bool has_more_paths(const Scenario& scenario) {
  return scenario.multipath || scenario.bounces > 0 || has_walls(scenario);
}

Material material_of(const MaterialSpec& spec, const ScatteringSpec& scattering) {
  Material material;
  material.reflectivity = spec.reflectivity;
  material.law = spec.law;
  if (auto* lambert = std::get_if<Lambert>(&material.law); lambert && !lambert->exponent) {
    lambert->exponent = scattering.lambert_exponent;
  }
  if (const auto* rician = std::get_if<RicianSpec>(&spec.coherent)) {
    material.coherent = CoherentModel::rician;
    material.rician_k = rician->k;
  } else if (const auto* kirchhoff = std::get_if<KirchhoffSpec>(&spec.coherent)) {
    material.coherent = CoherentModel::kirchhoff;
    material.reflection = kirchhoff->reflection;
    material.roughness_rms_m = kirchhoff->roughness_rms_m;
    material.roughness_correlation_m = kirchhoff->roughness_correlation_m.value_or(0);
    material.edges = kirchhoff->edges;
  }
  if (spec.texture) material.texture = *spec.texture;
  material.wall = spec.wall;
  if (material.wall) material.reflection = 1;
  return material;
}

}  // namespace ensonify
