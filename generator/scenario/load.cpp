// Turns the text of a file into a checked scenario, and a scenario into text.
#include <algorithm>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <system_error>
#include <tuple>

#include <fmt/format.h>

#include "scenario/distribution.h"
#include "scenario/draw.h"
#include "scenario/drawn_sections.h"
#include "scenario/field_writer.h"
#include "scenario/known_materials.h"
#include "scenario/merge.h"
#include "scenario/rig.h"
#include "scenario/sections.h"
#include "scenario/text.h"
#include "scenario/value_text.h"
#include "scenario/yaml_text.h"

namespace ensonify {
namespace {

// A scenario without a name takes the name of its file.
std::string default_name(const std::string& label) {
  const std::string stem = std::filesystem::path(label).stem().string();
  const bool printable = !first_invalid_utf8(stem) && !first_control_character(stem, "");
  return printable && !stem.empty() && label != kStandardInput && stem.size() <= kMaxNameBytes
             ? stem
             : "scenario";
}

bool same_place(const Place& a, const Place& b) {
  return a.source == b.source && a.line == b.line && a.column == b.column;
}

// A distribution that cannot be sampled has been reported already, so later errors at its place are
// dropped.
void drop_faults_at(const std::vector<Place>& places, std::size_t first, Faults& faults) {
  const auto begin = faults.list.begin() + static_cast<std::ptrdiff_t>(first);
  const auto told = [&](const Fault& fault) {
    return std::any_of(places.begin(), places.end(),
                       [&](const Place& place) { return same_place(place, fault.place); });
  };
  faults.list.erase(std::remove_if(begin, faults.list.end(), told), faults.list.end());
}

Scenario read_scenario(const InputFolder& input, const Value& root, const std::string& label) {
  Scenario scenario;
  scenario.name = default_name(label);
  scenario.trajectory.pings = 1;
  if (const auto sweep = child(root, "ensonify_sweep")) {
    add_fault(input.faults, sweep->place, sweep->path,
              "this is a sweep; expected a scenario (`ensonify sweep` reads sweeps)");
    return scenario;
  }
  FieldReader reader(input, root);
  fields(reader, scenario);
  reader.end();
  return scenario;
}

// The extremes of a large choice are checked until this many values have been copied, which takes
// one to two seconds. Reading a value takes as long as copying 30.
constexpr std::size_t kMostCopiedAtExtremes = 50'000'000;
constexpr std::size_t kCopiesPerReading = 30;

using PlaceKey = std::tuple<int, int, int>;
PlaceKey place_key(const Place& place) { return {place.source, place.line, place.column}; }

// All places in distributions and at uses of variables; places of numbers with the text of their
// distribution.
using DrawnPlaces = std::map<PlaceKey, std::string>;

void add_drawn_places(const Node& node, bool within, DrawnPlaces& places) {
  const bool is_drawn = is_distribution(node);
  within = within || is_drawn;
  const bool is_number = is_drawn && node.keys[0].text != "choice";
  const std::string text = is_number ? flow_text(node) : "";
  if (within || is_use(node)) {
    const auto [at, is_new] = places.try_emplace(place_key(node.place), text);
    if (!is_new && at->second != text) at->second.clear();  // all values of a --set share a place
  }
  for (const Key& key : node.keys) {
    if (within) places.try_emplace(place_key(key.place));
  }
  for (const Node& item : node.items) add_drawn_places(item, within, places);
}

// Returns how many values were read.
std::size_t read_extreme(Node tree, const DrawExtreme& extreme, const std::string& label,
                         const InputFolder& input) {
  lay_known_materials(tree);
  std::vector<Place> wrong;
  std::vector<VariableUse> uses;
  draw_extremes(tree, extreme, input.faults, wrong, uses);
  lay_known_materials(tree);  // presets that were sampled
  const std::size_t before = input.faults.list.size();
  read_scenario(input, {&tree, tree.place, ""}, label);
  drop_faults_at(wrong, before, input.faults);
  name_variables(uses, before, input.faults);
  return values_in(tree);
}

// Whoever runs a scenario from an untrusted source should know which local files it reads.
std::vector<std::string> notices_of_files(const Scenario& scenario,
                                          const std::filesystem::path& folder) {
  std::vector<std::string> notices;
  std::error_code error;
  const auto home = std::filesystem::weakly_canonical(folder.empty() ? "." : folder, error);
  for (const std::filesystem::path& file : input_files(scenario)) {
    const auto found = std::filesystem::weakly_canonical(file, error);
    const auto apart = std::mismatch(home.begin(), home.end(), found.begin(), found.end());
    if (apart.first == home.end()) continue;
    notices.push_back(one_line(fmt::format(
        "{} is outside the folder of the scenario; its contents are copied into the data set",
        found.string())));
  }
  return notices;
}

}  // namespace

std::string to_yaml(const Scenario& scenario, const NameFile& name_file) {
  Scenario copy = scenario;
  if (!copy.rig.empty()) copy.output = copy.rig_output;
  FieldWriter writer(scenario, name_file);
  fields(writer, copy);
  return writer.text_of_scenario();
}

std::vector<std::filesystem::path> input_files(const Scenario& scenario) {
  std::vector<std::filesystem::path> files;
  to_yaml(scenario, [&](const std::filesystem::path& file) {
    if (std::find(files.begin(), files.end(), file) == files.end()) files.push_back(file);
    return std::string();
  });
  return files;
}

std::optional<Scenario> parse_scenario_tree(Node tree, const std::string& label,
                                            const std::filesystem::path& folder, Faults& faults,
                                            SequenceDraw draw) {
  const InputFolder input{folder, faults};
  lay_known_materials(tree);
  const Value root{&tree, tree.place, ""};
  auto sections = keep_drawn_sections(tree, input);
  const bool drawn = holds_distribution(tree);
  Node defined;
  if (uses_variables(tree)) defined = with_definitions(tree, faults.limits.copied_values);
  const Value all_draws = defined.items.empty() ? root : Value{&defined, tree.place, ""};
  ClassList classes = class_list(faults, all_draws);
  const std::vector<std::string> targets = layer_target_words(all_draws);
  std::uint64_t seed = 0;
  Faults told_later;
  read_seed(told_later, root, "seed", seed);
  std::vector<Place> wrong;
  std::vector<VariableUse> uses;
  std::vector<DrawnValue> draws;
  draw_values(tree, seed, draw, faults, wrong, uses, draws);
  lay_known_materials(tree);  // presets that were sampled
  const std::size_t before = faults.list.size();
  Scenario scenario = read_scenario(input, root, label);
  check_layer_targets(faults, root, targets);
  drop_faults_at(wrong, before, faults);
  name_variables(uses, before, faults);
  if (!faults.empty()) return std::nullopt;
  scenario.has_draws = drawn || std::any_of(scenario.objects.begin(), scenario.objects.end(),
                                            [](const ObjectSpec& o) { return o.place; });
  scenario.redraw = draw.redraw;
  scenario.draws = std::move(draws);
  scenario.class_names = std::move(classes.names);
  scenario.class_kinds = std::move(classes.kinds);
  scenario.drawn_sections = std::move(sections);
  scenario.notices = notices_of_files(scenario, folder);
  const std::vector<std::string>& of_sonar = scenario.sonar.notices;
  scenario.notices.insert(scenario.notices.end(), of_sonar.begin(), of_sonar.end());
  return scenario;
}

Result<Scenario> parse_scenario(const std::string& text, const std::string& label,
                                const std::filesystem::path& folder,
                                const std::vector<Override>& overrides, SequenceDraw draw,
                                const ReadLimits& limits, ErrorPlaces places) {
  Faults faults;
  faults.limits = limits;
  std::optional<Node> tree = read_yaml_map(text, add_source(faults, label), faults);
  if (!tree) return to_error(faults, places);
  apply_overrides(*tree, overrides, faults);
  auto scenario = parse_scenario_tree(std::move(*tree), label, folder, faults, draw);
  if (!scenario) return to_error(faults, places);
  return std::move(*scenario);
}

void check_draws(const Node& tree, const std::string& label, const std::filesystem::path& folder,
                 Faults& faults) {
  if (!holds_distribution(tree)) return;
  DrawnPlaces drawn;
  add_drawn_places(tree, false, drawn);
  const std::size_t variants = draw_variants(tree);
  const std::size_t all = values_in(tree);
  std::size_t copied = 0;
  for (std::size_t variant = 0; variant < variants && copied < kMostCopiedAtExtremes; ++variant) {
    for (const bool is_upper : {false, true}) {
      Faults found;
      found.limits = faults.limits;
      found.sources = faults.sources;
      copied +=
          all + kCopiesPerReading * read_extreme(tree, {is_upper, variant}, label, {folder, found});
      for (const Fault& fault : found.list) {
        const auto at = drawn.find(place_key(fault.place));
        if (at == drawn.end()) continue;
        const std::string reached =
            at->second.empty() ? "" : fmt::format("; {} reaches it", at->second);
        add_fault(faults, fault.place, fault.path, fault.text + reached);
      }
    }
  }
}

bool is_sampled(const std::string& text, const std::vector<Override>& overrides) {
  Faults faults;
  std::optional<Node> tree = read_yaml_map(text, add_source(faults, ""), faults);
  if (tree) apply_overrides(*tree, overrides, faults);
  return tree && holds_distribution(*tree);
}

Status check_draws(const std::string& text, const std::string& label,
                   const std::filesystem::path& folder, const std::vector<Override>& overrides) {
  Faults faults;
  std::optional<Node> tree = read_yaml_map(text, add_source(faults, label), faults);
  if (tree) apply_overrides(*tree, overrides, faults);
  if (tree) check_draws(*tree, label, folder, faults);
  return faults.empty() ? Status() : to_error(faults);
}

namespace {

template <class Refuse>
Result<std::string> text_of(std::istream& stream, const Refuse& refuse) {
  // Reads at most one block more than the limit, so that an endless pipe ends and is refused.
  constexpr std::size_t kBlock = 1 << 16;
  std::string text;
  while (stream && text.size() <= kMaxYamlBytes) {
    const std::size_t held = text.size();
    text.resize(held + kBlock);
    stream.read(text.data() + held, kBlock);
    text.resize(held + static_cast<std::size_t>(stream.gcount()));
  }
  if (stream.bad()) return refuse(ErrorKind::io, "cannot be read");
  return text;
}

}  // namespace

Result<std::string> read_scenario_text(const std::filesystem::path& file, std::string_view what) {
  const std::string label = file.string();
  const auto refuse = [&](ErrorKind kind, const std::string& trouble) {
    return Error{kind, one_line(fmt::format("{}: {}; expected {} in YAML", label, trouble, what))};
  };
  if (file == kStandardInput) return text_of(std::cin, refuse);
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) return refuse(ErrorKind::usage, "no such file");
  if (std::filesystem::is_directory(status)) return refuse(ErrorKind::usage, "is a folder");
  if (std::filesystem::is_regular_file(status) &&
      std::filesystem::file_size(file, error) > kMaxYamlBytes) {
    return refuse(ErrorKind::usage, fmt::format("larger than {} MiB", kMaxYamlBytes >> 20));
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return refuse(ErrorKind::io, "cannot be opened");
  return text_of(stream, refuse);
}

Result<Scenario> load_scenario(const std::filesystem::path& file,
                               const std::vector<Override>& overrides, SequenceDraw draw) {
  const Result<std::string> text = read_scenario_text(file);
  if (!text) return text.error();
  return parse_scenario(*text, file.string(), file.parent_path(), overrides, draw);
}

Error with_place(const Error& error, const std::string& text, const std::string& label,
                 const std::vector<Override>& overrides) {
  const std::string path = error.message.substr(0, error.message.find(": "));
  for (const Override& given : overrides) {
    if (path.starts_with(given.path) || given.path.starts_with(path)) return error;
  }
  Faults faults;
  const std::optional<Node> tree = read_yaml_map(text, add_source(faults, label), faults);
  if (!tree) return error;
  const std::string text_path = path_in_rig(*tree, path, overrides);
  const auto place = place_in(*tree, text_path);
  if (!place) return error;
  return {error.kind, fmt::format("{}:{}:{}: {}{}", label, place->line, place->column, text_path,
                                  error.message.substr(path.size()))};
}

}  // namespace ensonify
