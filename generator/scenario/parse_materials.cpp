#include "scenario/parse.h"

namespace ensonify {
namespace {

// How the surface scatters at random, and the reflectivity that goes with it.
void parse_law(const InputFolder& input, const Value& map, MaterialSpec& material) {
  Faults& faults = input.faults;
  const auto law = read_kind(faults, map, "law", {"lambert", "lommel_seeliger", "table"});
  if (law && law->word == "table") {
    BackscatterTableSpec table;
    if (open_map(faults, law->options, {"file"})) {
      parse_input_file(input, law->options, "file", {".csv"}, table.file);
    }
    material.law = table;
    refuse_useless(faults, map, {"reflectivity"},
                   "beside a table, which holds the strength itself; accepted is either alone");
    return;
  }
  if (law && law->word == "lambert" && open_map(faults, law->options, {"exponent"})) {
    LambertSpec lambert;
    double exponent = 1;
    if (read_number(faults, law->options, "exponent", kLambertExponent, exponent)) {
      lambert.exponent = exponent;
    }
    material.law = lambert;
  }
  if (law && law->word == "lommel_seeliger" && open_map(faults, law->options, {})) {
    material.law = LommelSeeligerSpec{};
  }
  // A law that cannot be read may have been a table.
  const Need need = law || !child(map, "law") ? Need::required : Need::optional;
  read_number(faults, map, "reflectivity", from_to(0, 1e6), material.reflectivity, need);
}

// What the surface throws back in phase.
void parse_coherent(Faults& faults, const Value& coherent, CoherentSpec& spec) {
  if (!open_map(faults, coherent, {"model", "k", "reflection", "roughness_rms_m"})) return;
  const auto model = read_word(faults, coherent, "model", {"rician", "kirchhoff"}, Need::required);
  if (model == 0u) {
    RicianSpec rician;
    read_number(faults, coherent, "k", from_to(0, 1e6), rician.k, Need::required);
    refuse_useless(faults, coherent, {"reflection", "roughness_rms_m"},
                   "in the model rician, accepted with kirchhoff");
    spec = rician;
  } else if (model == 1u) {
    KirchhoffSpec kirchhoff;
    read_number(faults, coherent, "reflection", from_to(-1, 1), kirchhoff.reflection);
    read_number(faults, coherent, "roughness_rms_m", from_to(0, 1), kirchhoff.roughness_rms_m);
    refuse_useless(faults, coherent, {"k"}, "in the model kirchhoff, accepted with rician");
    spec = kirchhoff;
  }
}

}  // namespace

void parse_materials(const InputFolder& input, const Value& value,
                     std::vector<MaterialSpec>& materials) {
  Faults& faults = input.faults;
  if (value.node->kind != NodeKind::map) {
    add_fault(faults, value.place, value.path,
              "no map, accepted is a map of names, as in {steel: {reflectivity: 1e-2}}");
    return;
  }
  for (std::size_t i = 0; i < value.node->keys.size(); ++i) {
    const Key& key = value.node->keys[i];
    const Node& node = value.node->items[i];
    const Value map{&node, node.place, path_of(value, key.text)};
    MaterialSpec material;
    material.name = key.text;
    const bool named = is_name(faults, key, map.path);
    if (open_map(faults, map, {"reflectivity", "law", "coherent"})) {
      parse_law(input, map, material);
      if (const auto coherent = child(map, "coherent")) {
        parse_coherent(faults, *coherent, material.coherent);
      }
    }
    if (named) materials.push_back(std::move(material));
  }
}

}  // namespace ensonify
