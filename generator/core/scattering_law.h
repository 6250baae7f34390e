// The laws by which the backscatter of a surface depends on the angle. A law is one struct here:
// its word and texts, its parameters, its formulas. Scenario keys, sequence.json, schemas and docs
// follow from ScatteringLaw, the list of all.
//
//   BackscatterTable  tabulated_db   measured strength against grazing angle
//   Lambert  LommelSeeliger  MeasuredStrength
//   ScatteringLaw                    one of them
//   kLawWords  law_at  name_of       by their words in files
//   states_strength                  whether a law has no reflectivity
//
// A law has three formulas. mu is the backscatter at normal incidence, per steradian; angles of
// incidence and scattering are given by their cosines, as 0 along the surface.
//   backscatter(mu, cos_i)       cross-section of a unit of surface area, per steradian
//   per_cross_section(mu, cos_i)   ... divided by cos_i, per unit of the rays' cross-section
//   bistatic(mu, cos_i, cos_s)   from one direction to another: symmetric, and backscatter for
//                                equal directions
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/keys.h"

namespace ensonify {

struct BackscatterTable {
  std::vector<double> grazing_rad;  // rising, from 0 (along the surface) to pi/2
  std::vector<double> strength_db;  // dB re 1 m^2/m^2 per steradian of backscatter
};

// Linear in dB between the rows.
double tabulated_db(const BackscatterTable& table, double grazing_rad);

struct LawText {
  std::string_view word, title, meaning;  // of the schema and docs/scenario_keys.md
};

// A parameter: a key of the law in scenarios, and a member of sequence.json.
template <class Law>
struct LawParameter {
  using Value = std::optional<double> Law::*;
  const char* key;
  std::string_view title, meaning;
  double least, most;
  Value value;                 // set once a scenario is resolved
  Need need = Need::required;  // optional: material_of (scenario/) sets what is left out
};

// Lambert's law for n = 1; Eq 14 of Choi et al. 2021 for n = 2.
struct Lambert {
  static constexpr LawText kText = {
      "lambert", "Lambert", "Backscattering coefficient μ cosⁿ⁺¹(α) at the angle of incidence α"};
  static constexpr auto parameters() {
    return std::array{LawParameter<Lambert>{"exponent", "Exponent",
                                            "n; left out: the value of scattering.lambert_exponent",
                                            0, 100, &Lambert::exponent, Need::optional}};
  }

  std::optional<double> exponent = {};  // n

  double backscatter(double mu, double cos_i) const { return mu * std::pow(cos_i, *exponent + 1); }
  double per_cross_section(double mu, double cos_i) const {
    // What most rays meet needs no power. These equal the power for cosines that were floats.
    if (*exponent == 1) return mu * cos_i;
    if (*exponent == 2) return mu * (cos_i * cos_i);
    return mu * std::pow(cos_i, *exponent);
  }
  double bistatic(double mu, double cos_i, double cos_s) const {
    return mu * std::pow(cos_i * cos_s, (*exponent + 1) / 2);
  }
};

// Lommel 1887, Seeliger 1887: a medium that scatters once below its surface.
struct LommelSeeliger {
  static constexpr LawText kText = {
      "lommel_seeliger", "Lommel-Seeliger",
      "Backscattering coefficient μ cos(α) at the angle of incidence α"};
  static constexpr auto parameters() { return std::array<LawParameter<LommelSeeliger>, 0>{}; }

  double backscatter(double mu, double cos_i) const { return mu * cos_i; }
  double per_cross_section(double mu, double) const { return mu; }  // 0/0 is not computed
  double bistatic(double mu, double cos_i, double cos_s) const {
    return mu * 2 * (cos_i * cos_s) / (cos_i + cos_s);
  }
};

// The table states the strength itself. Between two directions it is the geometric mean of both
// directions' backscatter.
struct MeasuredStrength {
  static constexpr LawText kText = {
      "table", "Measured strength",
      "Backscattering strength from a table, linear in dB between rows"};
  static constexpr auto parameters() { return std::array<LawParameter<MeasuredStrength>, 0>{}; }

  std::filesystem::path file = {};  // of a scenario: CSV with grazing_deg, strength_db
  BackscatterTable table = {};      // once its world is built

  double backscatter(double, double cos_i) const {
    return std::pow(10.0, tabulated_db(table, std::asin(cos_i)) / 10);
  }
  double per_cross_section(double mu, double cos_i) const { return backscatter(mu, cos_i) / cos_i; }
  double bistatic(double mu, double cos_i, double cos_s) const {
    return std::sqrt(backscatter(mu, cos_i) * backscatter(mu, cos_s));
  }
};

using ScatteringLaw = std::variant<Lambert, LommelSeeliger, MeasuredStrength>;
inline constexpr std::size_t kLawCount = std::variant_size_v<ScatteringLaw>;

// One value for each law, in the order of ScatteringLaw, of its std::type_identity.
template <class Of>
constexpr auto of_laws(Of of) {
  return [&]<std::size_t... I>(std::index_sequence<I...>) {
    return std::array{of(std::type_identity<std::variant_alternative_t<I, ScatteringLaw>>())...};
  }
  (std::make_index_sequence<kLawCount>{});
}
inline constexpr auto kLawWords = of_laws([](auto law) { return decltype(law)::type::kText.word; });

// The law with this index, without the values of its parameters.
inline ScatteringLaw law_at(std::size_t index) {
  return of_laws([](auto law) { return ScatteringLaw(typename decltype(law)::type{}); })[index];
}

inline std::string_view name_of(const ScatteringLaw& law) { return kLawWords[law.index()]; }

inline bool states_strength(const ScatteringLaw& law) {
  return std::holds_alternative<MeasuredStrength>(law);
}

}  // namespace ensonify
