// What `output` says of each kind of file.
#include <algorithm>

#include <fmt/format.h>

#include "scenario/sections.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr int kMaxImageHeight = 16384;
constexpr int kMaxSdfBand = 100;
constexpr NumberRange kSpreading = from_to(0, 100);
constexpr NumberRange kGreyDb = from_to(-1000, 1000);

struct SeriesFormats {
  bool npy = true, exr = false;
  friend bool operator==(const SeriesFormats&, const SeriesFormats&) = default;
};

void timeseries_field(Fields& f, OutputSelection& selection) {
  SeriesFormats formats{selection.timeseries, selection.timeseries_exr};
  f.choice<SeriesFormats>("timeseries", formats,
                          {{"npy", {true, false}},
                           {"exr", {false, true}},
                           {"both", {true, true}},
                           {"none", {false, false}}});
  selection.timeseries = formats.npy;
  selection.timeseries_exr = formats.exr;
}

// `true` is what echoes of single targets need, 40 log10 r + 2 alpha r.
void tvg_fields(Fields& f, GreySettings& grey) {
  bool on = f.writing();
  const bool has_options = f.begin_switch("tvg", on);
  if (!f.writing() && on) {
    grey.spreading = 40;
    grey.absorption = true;
  }
  if (!has_options) return;
  f.number("spreading", grey.spreading, kSpreading);
  f.boolean("absorption", grey.absorption);
  f.end();
}

void png_fields(Fields& f, OutputSpec& output) {
  if (!f.begin_switch("png", output.selection.png)) return;
  const bool plain = !output.png_db && output.png == GreySettings{};
  if (!f.writing() || !plain) {
    f.choice<GreyScale>("scale", output.png.scale,
                        {{"db", GreyScale::db}, {"amplitude", GreyScale::amplitude}});
    const bool limited = f.numbers("db", output.png_db, kGreyDb);
    if (limited && (*output.png_db)[0] >= (*output.png_db)[1]) {
      f.fault("db", fmt::format("the first level, {} dB, is not below the second, {} dB; accepted "
                                "is [black, white] with black below white",
                                (*output.png_db)[0], (*output.png_db)[1]));
    }
    tvg_fields(f, output.png);
    f.number("gain_db", output.png.gain_db, kGreyDb);
  }
  f.end();
}

// Labels that go with images: on where there are polar or Cartesian ones.
void hidden_label_fields(Fields& f, OutputSelection& selection) {
  const bool with_labels = selection.polar || selection.cartesian;
  const auto label = [&](const char* key, bool possible, const char* pictures, bool& wanted) {
    if (!f.writing()) wanted = with_labels;
    f.toggle(key, wanted);
    if (f.peek(key) == nullptr || !wanted || possible) return;
    f.fault(key, fmt::format("there are no pictures for it, accepted with {}", pictures));
  };
  label("shadow", with_labels, "polar or cartesian", selection.shadow);
  label("amodal", with_labels || selection.png, "polar, cartesian or png", selection.amodal);
}

void layers_fields(Fields& f, OutputSpec& output) {
  if (!f.begin_switch("layers", output.selection.layers)) return;
  std::vector<std::string> targets = output.layer_targets.value_or(std::vector<std::string>{});
  if (f.list("targets", targets, {}, written_if(output.layer_targets.has_value()),
             [&](const std::string& at, std::string& name) { f.text(at, name); })) {
    output.layer_targets = std::move(targets);
  }
  f.end();
}

void pack_field(Fields& f, OutputSelection& selection) {
  f.choice<bool>("pack", selection.packed, {{"ping", false}, {"sequence", true}});
  if (!selection.packed || !selection.timeseries_exr) return;
  f.fault("pack",
          "sequence holds arrays, and output.timeseries asks for EXR files of each ping; accepted "
          "with it is timeseries npy or none");
}

void sdf_fields(Fields& f, std::optional<SdfGrid>& sdf) {
  bool on = sdf.has_value();
  const bool has_options = f.begin_switch("sdf", on, written_if(on));
  if (!on) return;
  if (!sdf) sdf.emplace();
  if (has_options) {
    f.number("voxel_m", sdf->voxel_m, above_up_to(0, kMaxLengthM), kRequired);
    f.integer("band_voxels", sdf->band_voxels, 1, kMaxSdfBand);
    f.end();
  } else if (const FieldReader* reader = f.reader()) {
    const Value value = *child(reader->map(), "sdf");
    add_fault(reader->faults(), value.place, path_of(value, "voxel_m"),
              "missing, accepted is a map with it, as in {voxel_m: 0.05}");
  }
}

// The last of them: without pings it takes away what the others ask for.
void pings_field(Fields& f, OutputSelection& selection) {
  f.toggle("pings", selection.pings, written_if(selection.statistics));
  if (f.writing() || selection.pings) return;
  if (!selection.statistics) {
    f.fault("pings",
            "without statistics nothing would be written; accepted is false with statistics "
            "true");
  }
  OutputSelection none;
  none.timeseries = none.polar = none.cartesian = none.png = none.shadow = none.amodal = false;
  none.statistics = selection.statistics;
  none.pings = false;
  selection = none;
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

void output_fields(Fields& f, Scenario& scenario) {
  OutputSpec& output = scenario.output;
  OutputSelection& selection = output.selection;
  timeseries_field(f, selection);
  f.toggle("polar", selection.polar);
  if (f.begin_switch("cartesian", selection.cartesian)) {
    f.integer("height_px", output.cartesian_height_px, 1, kMaxImageHeight);
    f.end();
  }
  png_fields(f, output);
  hidden_label_fields(f, selection);
  const bool pictures = selection.polar || selection.cartesian;
  const bool bounces = scenario.multipath.has_value();
  if (!f.writing()) selection.multipath = bounces && pictures;
  f.toggle("multipath", selection.multipath, written_if(bounces));
  f.toggle("polygons", selection.polygons);
  f.toggle("scatterers", selection.scatterers);
  f.toggle("points", selection.points);
  layers_fields(f, output);
  pack_field(f, selection);
  f.toggle("channels", selection.channels, written_if(selection.channels));
  sdf_fields(f, output.sdf);
  f.toggle("statistics", selection.statistics, written_if(selection.statistics));
  pings_field(f, selection);
  if (!selection.multipath || (bounces && pictures)) return;
  f.fault("multipath", pictures ? "nothing bounces, accepted with multipath"
                                : "there are no pictures for it, accepted with polar or cartesian");
}

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

}  // namespace ensonify
