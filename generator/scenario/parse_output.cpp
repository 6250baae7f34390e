// What `output` says of each kind of file; parse_output goes through them.
#include <algorithm>

#include <fmt/format.h>

#include "scenario/parse.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr NumberRange kSpreading = from_to(0, 100);

void parse_limits(Faults& faults, const Value& png, OutputSpec& spec) {
  std::array<double, 2> limits{};
  if (!read_numbers(faults, png, "db", from_to(-1000, 1000), limits)) return;
  if (limits[0] < limits[1]) {
    spec.png_db = limits;
    return;
  }
  const Value db = *child(png, "db");
  add_fault(faults, db.place, db.path,
            fmt::format("the first level, {} dB, is not below the second, {} dB; accepted is "
                        "[black, white] with black below white",
                        limits[0], limits[1]));
}

// `true` is what echoes of single targets need, 40 log10 r + 2 alpha r.
void parse_tvg(Faults& faults, const Value& png, GreySettings& grey) {
  bool on = false;
  const auto map = read_switch(faults, png, "tvg", on);
  if (!on) return;
  grey.spreading = 40;
  grey.absorption = true;
  if (!map || !open_map(faults, *map, {"spreading", "absorption"})) return;
  read_number(faults, *map, "spreading", kSpreading, grey.spreading);
  read_boolean(faults, *map, "absorption", grey.absorption);
}

// Names and classes anywhere below, so that those behind a choice are found.
void add_names(const Node& node, std::vector<std::string>& words) {
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const bool is_map = node.kind == NodeKind::map;
    const bool named = is_map && (node.keys[i].text == "name" || node.keys[i].text == "class");
    if (named && node.items[i].kind == NodeKind::scalar) words.push_back(node.items[i].text);
    add_names(node.items[i], words);
  }
}

// The name of the entry with a count that `name` may stem from.
std::string without_number(const std::string& name) {
  const auto digits = name.find_last_not_of("0123456789");
  if (digits == std::string::npos || digits + 1 == name.size() || name[digits] != '_') return name;
  return name.substr(0, digits);
}

}  // namespace

std::vector<std::string> layer_target_words(const Value& root) {
  std::vector<std::string> words = {ObjectSpec{}.class_name, PointTargetSpec{}.class_name};
  for (const char* section : {"objects", "point_targets"}) {
    if (const auto list = child(root, section)) add_names(*list->node, words);
  }
  return words;
}

void check_layer_targets(Faults& faults, const Value& root, const std::vector<std::string>& words) {
  const auto output = child(root, "output");
  const auto layers = output ? child(*output, "layers") : std::nullopt;
  const auto targets = layers ? child(*layers, "targets") : std::nullopt;
  if (!targets || targets->node->kind != NodeKind::list) return;
  const std::vector<std::string_view> known(words.begin(), words.end());
  for (std::size_t i = 0; i < targets->node->items.size(); ++i) {
    const Value word = item(*targets, i);
    const std::string& text = word.node->text;
    const auto is_known = [&](const std::string& name) {
      return std::find(words.begin(), words.end(), name) != words.end();
    };
    if (word.node->kind != NodeKind::scalar || is_known(text) || is_known(without_number(text))) {
      continue;
    }
    add_fault(faults, word.place, word.path,
              fmt::format("{} is no object, point target or class of them{}; accepted are their "
                          "names and classes (volumes are the layer volume)",
                          shown(text), hint(text, known)));
  }
}

void parse_layers(Faults& faults, const Value& output, OutputSpec& spec) {
  const auto map = read_switch(faults, output, "layers", spec.selection.layers);
  if (!map || !open_map(faults, *map, {"targets"})) return;
  const auto targets = child(*map, "targets");
  if (!targets || !open_list(faults, *targets)) return;
  spec.layer_targets.emplace();
  for (std::size_t i = 0; i < targets->node->items.size(); ++i) {
    const Value word = item(*targets, i);
    if (word.node->kind == NodeKind::scalar) {
      spec.layer_targets->push_back(word.node->text);
    } else {
      add_fault(faults, word.place, word.path, "accepted is the name of an object or class");
    }
  }
}

void parse_pack(Faults& faults, const Value& output, OutputSelection& selection) {
  read_choice<bool>(faults, output, "pack", {{"ping", false}, {"sequence", true}},
                    selection.packed);
  if (!selection.packed || !selection.timeseries_exr) return;
  const Value pack = *child(output, "pack");
  add_fault(
      faults, pack.place, pack.path,
      "sequence holds arrays, and output.timeseries asks for EXR files of each ping; accepted "
      "with it is timeseries npy or none");
}

void parse_pings(Faults& faults, const Value& output, OutputSelection& selection) {
  if (const auto map = read_switch(faults, output, "pings", selection.pings)) {
    open_map(faults, *map, {});
  }
  if (selection.pings) return;
  if (!selection.statistics) {
    const Value pings = *child(output, "pings");
    add_fault(faults, pings.place, pings.path,
              "without statistics nothing would be written; accepted is false with statistics "
              "true");
  }
  OutputSelection none;
  none.timeseries = none.polar = none.cartesian = none.png = none.shadow = none.amodal = false;
  none.statistics = selection.statistics;
  none.pings = false;
  selection = none;
}

void parse_png(Faults& faults, const Value& output, OutputSpec& spec) {
  const auto png = read_switch(faults, output, "png", spec.selection.png);
  if (!png || !open_map(faults, *png, {"scale", "db", "tvg", "gain_db"})) return;
  read_choice<GreyScale>(faults, *png, "scale",
                         {{"db", GreyScale::db}, {"amplitude", GreyScale::amplitude}},
                         spec.png.scale);
  parse_limits(faults, *png, spec);
  parse_tvg(faults, *png, spec.png);
  read_number(faults, *png, "gain_db", from_to(-1000, 1000), spec.png.gain_db);
}

void parse_timeseries(Faults& faults, const Value& output, OutputSelection& selection) {
  struct Formats {
    bool npy = true, exr = false;
  } formats;
  const bool given = read_choice<Formats>(faults, output, "timeseries",
                                          {{"npy", {true, false}},
                                           {"exr", {false, true}},
                                           {"both", {true, true}},
                                           {"none", {false, false}}},
                                          formats);
  if (!given) return;
  selection.timeseries = formats.npy;
  selection.timeseries_exr = formats.exr;
}

}  // namespace ensonify
