#include "scenario/rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <utility>

#include "scenario/merge.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

constexpr std::string_view kRig = "rig", kSonar = "sonar", kInstrument = "instrument";
constexpr std::string_view kKinds[] = {kSonar, "camera", "navigation"};  // as InstrumentKind

constexpr std::size_t kMostInstruments = 16;
constexpr std::size_t kLongestName = 64;

// Folders that data sets and sweeps have at their top.
constexpr std::array<std::string_view, 6> kTakenNames = {"assets", "failed",    "renders",
                                                         "runs",   "sequences", "splits"};

// The name in lower case, since some file systems do not distinguish the cases of letters.
std::string folded(std::string_view name) {
  std::string text(name);
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_folder_name(std::string_view name) {
  const auto is_alphanumeric = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  };
  return !name.empty() && name.size() <= kLongestName && is_alphanumeric(name.front()) &&
         std::ranges::all_of(name,
                             [&](char c) { return is_alphanumeric(c) || c == '_' || c == '-'; });
}

void check_name(Fields& f, const std::string& name) {
  if (!is_folder_name(name)) {
    f.fault("name", fmt::format("{} is not the name of a folder; expected up to {} letters, "
                                "digits, _ and -, the first one a letter or a digit",
                                shown(name), kLongestName));
  } else if (std::ranges::find(kTakenNames, folded(name)) != kTakenNames.end()) {
    f.fault("name", fmt::format("{} is a folder of data sets and sweeps; expected another name",
                                shown(name)));
  }
}

// Names that differ in the case of letters alone collide, too.
void check_names(const FieldReader& reader, const std::vector<InstrumentSpec>& rig) {
  const Value list = child_or_empty(reader.map(), kRig);
  std::set<std::string> seen;
  for (std::size_t i = 0; i < rig.size(); ++i) {
    if (rig[i].name.empty() || seen.insert(folded(rig[i].name)).second) continue;
    const Value entry = item(list, i);
    const Value name = child_or_empty(entry, "name");
    add_fault(reader.faults(), name.place, name.path,
              fmt::format("another instrument has the folder {}; expected a name that differs in "
                          "more than the case of its letters",
                          shown(rig[i].name)));
  }
}

std::vector<std::string_view> names_of(const std::vector<InstrumentSpec>& rig) {
  std::vector<std::string_view> names;
  for (const InstrumentSpec& instrument : rig) names.push_back(instrument.name);
  return names;
}

InstrumentKind kind_of(const InstrumentSpec& instrument) {
  if (instrument.camera) return InstrumentKind::camera;
  return instrument.navigation ? InstrumentKind::navigation : InstrumentKind::sonar;
}

// Stands for the sonar of an instrument that has none: a ray and a few samples, which nobody hears.
SonarSpec silent_sonar(const PoseSpec& mount) {
  SonarSpec sonar;
  sonar.frequency_hz = 1000;
  sonar.bandwidth_hz = 100;
  sonar.range_max_m = 10;
  sonar.beam_count = sonar.rays_elevation = 1;
  sonar.beam_fov_deg = sonar.beam_width_deg = 10;
  sonar.elevation_width_deg = sonar.elevation_fan_deg = 10;
  sonar.rays_per_cell = 0;
  sonar.mount = mount;
  return sonar;
}

void take(const InstrumentSpec& instrument, Scenario& scenario) {
  const PoseSpec mount = instrument.camera ? instrument.camera->mount : PoseSpec{};
  scenario.instrument = instrument.name;
  scenario.sonar = instrument.sonar.value_or(silent_sonar(mount));
  scenario.camera = instrument.camera;
  scenario.navigation = instrument.navigation;
}

// Sections that a scenario with a rig has as instruments.
void refuse_sections(Fields& f, FieldReader& reader) {
  if (reader.peek(kSonar) != nullptr) {
    f.fault(kRig, "cannot be combined with sonar; expected only one of them");
  }
  for (const std::string_view key : {kKinds[1], kKinds[2]}) {
    if (reader.peek(key) == nullptr) continue;
    f.fault(key, fmt::format("cannot be combined with rig; expected it as an instrument of the "
                             "rig, - {{name: {0}, {0}: ...}}",
                             key));
  }
}

void choose(Fields& f, Scenario& scenario) {
  const auto chosen = chosen_index(scenario);
  if (chosen) return take(scenario.rig[*chosen], scenario);
  if (scenario.rig.empty()) return;
  const std::vector<std::string_view> names = names_of(scenario.rig);
  f.fault(kInstrument,
          scenario.instrument.empty()
              ? fmt::format("missing; the scenario has a rig, of which this command takes one "
                            "instrument: expected {} (--set instrument={}); `ensonify generate` "
                            "and `ensonify check` take all",
                            joined(names), names.front())
              : fmt::format("{} names no instrument of the rig{}; expected {}",
                            shown(scenario.instrument), hint(scenario.instrument, names),
                            joined(names)));
}

}  // namespace

static void fields(Fields& f, InstrumentSpec& instrument) {
  const ReadWatch watch(f);
  f.text({"name", "Name", "Name of the instrument and of the folder with its data set"},
         instrument.name, kRequired);
  if (watch.is_well()) check_name(f, instrument.name);
  const auto held = static_cast<std::size_t>(kind_of(instrument));
  const auto kind = f.only_key(kKinds, held, "one of sonar, camera and navigation");
  // A list of all keys has each in every look at them, not in a third.
  const bool is_list = !f.writing() && f.reader() == nullptr;
  if (is_list || kind == 0u) {
    f.map({kKinds[0], "Sonar",
           "A preset, keys that override it, or all keys without a preset; its mount is its pose "
           "on the body that the trajectory moves"},
          instrument.sonar, {.in_lines = true});
  }
  if (is_list || kind == 1u) {
    f.map({kKinds[1], "Camera", "A camera, in place of sonar, with images in place of pings"},
          instrument.camera);
  }
  if (is_list || kind == 2u) {
    f.map({kKinds[2], "Navigation", "Navigation sensors of the body, in place of sonar"},
          instrument.navigation);
  }
  f.number({"ping_rate_hz", "Ping rate",
            "Pings per second, of a camera its images, of navigation the poses of the body; left "
            "out: that of the trajectory"},
           instrument.ping_rate_hz, above_up_to(0, 1e6));
  f.number({"time_offset_s", "Time offset",
            "Time of the instrument's first ping, after the start of the trajectory; of navigation "
            "that from which its sensors count their own"},
           instrument.time_offset_s, from_to(0, 1e6));
}

void rig_fields(Fields& f, Scenario& scenario) {
  f.maps({kRig, "Rig",
          "Instruments on one body, in place of sonar, camera and navigation: each is in the same "
          "world and has a data set of its own; left out: one sonar"},
         scenario.rig, {.written = !scenario.rig.empty(), .in_lines = true},
         {"", fmt::format("a list of 1 to {} instruments", kMostInstruments), 1, kMostInstruments});
  f.text(
      {kInstrument, "Instrument",
       "Name of the instrument of the rig that is read; left out: `generate` and `check` take "
       "all of them"},
      scenario.instrument,
      useless_if(scenario.rig.empty(), "without a rig; expected no key", {.has_default = false}));
  FieldReader* reader = f.reader();
  if (reader == nullptr || reader->peek(kRig) == nullptr) return;
  refuse_sections(f, *reader);
  check_names(*reader, scenario.rig);
  choose(f, scenario);
}

void select_outputs(Scenario& scenario) {
  if (!chosen_index(scenario)) return;
  scenario.rig_output = scenario.output;
  const InstrumentKind kind = instrument_kind(scenario);
  const OutputSelection stated = scenario.output.selection;
  OutputSelection& own = scenario.output.selection;
  const bool is_camera = kind == InstrumentKind::camera;
  if (kind != InstrumentKind::sonar) {
    own = no_outputs();
    scenario.output.sdf.reset();
    scenario.output.height_map.reset();
  }
  own.packed = stated.packed && kind != InstrumentKind::navigation;
  own.camera_geometry = stated.camera_geometry && is_camera;
  own.camera_color = stated.camera_color && is_camera;
  own.camera_flow = stated.camera_flow && is_camera;
}

Node chosen_sonar_tree(const Node& root, std::size_t index) {
  Node tree = without(root, kRig);
  const Node* rig = find(root, kRig);
  if (rig == nullptr || index >= rig->items.size()) return tree;
  const Node* sonar = find(rig->items[index], kSonar);
  if (sonar == nullptr) return tree;
  tree.keys.push_back({std::string(kSonar), false, sonar->place});
  tree.items.push_back(*sonar);
  return tree;
}

std::vector<std::string> instruments_in(const std::string& text,
                                        const std::vector<Override>& overrides) {
  Faults faults;
  std::optional<Node> tree = read_yaml_map(text, add_source(faults, ""), faults);
  if (!tree) return {};
  apply_overrides(*tree, overrides, faults);
  const Node* rig = find(*tree, kRig);
  std::vector<std::string> names;
  if (rig == nullptr || rig->kind != NodeKind::list || find(*tree, kInstrument) != nullptr) {
    return names;
  }
  for (const Node& entry : rig->items) {
    const Node* name = entry.kind == NodeKind::map ? find(entry, "name") : nullptr;
    if (name != nullptr && is_folder_name(name->text)) names.push_back(name->text);
  }
  return names;
}

std::optional<std::size_t> chosen_index(const Scenario& scenario) {
  const auto chosen = std::ranges::find(scenario.rig, scenario.instrument, &InstrumentSpec::name);
  if (scenario.instrument.empty() || chosen == scenario.rig.end()) return std::nullopt;
  return static_cast<std::size_t>(chosen - scenario.rig.begin());
}

Scenario for_instrument(Scenario scenario, std::size_t index) {
  take(scenario.rig[index], scenario);
  return scenario;
}

InstrumentKind instrument_kind(const Scenario& scenario) {
  const auto chosen = chosen_index(scenario);
  return chosen ? kind_of(scenario.rig[*chosen]) : InstrumentKind::sonar;
}

Status need_sonar(const Scenario& scenario) {
  if (is_sonar(scenario)) return {};
  return Error{ErrorKind::usage, fmt::format("{}: {} is no sonar; expected a sonar of the rig",
                                             kInstrument, scenario.instrument)};
}

bool has_camera(const Scenario& scenario) {
  return scenario.camera || std::ranges::any_of(scenario.rig, [](const InstrumentSpec& instrument) {
           return instrument.camera.has_value();
         });
}

std::string in_rig(std::string_view path, std::size_t index) {
  const std::string_view section = path.substr(0, path.find('.'));
  const bool is_own = std::ranges::find(kKinds, section) != std::end(kKinds);
  return is_own ? fmt::format("{}.{}.{}", kRig, index, path) : std::string(path);
}

std::string path_in_rig(const Node& tree, const std::string& path,
                        const std::vector<Override>& overrides) {
  const Node* rig = find(tree, kRig);
  const Node* chosen = find(tree, kInstrument);
  std::string name = chosen != nullptr ? chosen->text : "";
  for (const Override& given : overrides) {
    if (given.path == kInstrument) name = given.value;
  }
  for (std::size_t i = 0; rig != nullptr && i < rig->items.size(); ++i) {
    const Node* own = rig->items[i].kind == NodeKind::map ? find(rig->items[i], "name") : nullptr;
    if (own != nullptr && own->text == name) return in_rig(path, i);
  }
  return path;
}

double ping_rate_hz(const Scenario& scenario) {
  const auto chosen = chosen_index(scenario);
  const double common_hz = scenario.trajectory.ping_rate_hz;
  return chosen ? scenario.rig[*chosen].ping_rate_hz.value_or(common_hz) : common_hz;
}

std::optional<std::uint64_t> instrument_seed(const Scenario& scenario) {
  if (!chosen_index(scenario)) return std::nullopt;
  return mix64(scenario.seed ^ name_key(scenario.instrument));
}

std::uint64_t device_seed(const Scenario& scenario) {
  return instrument_seed(scenario).value_or(scenario.seed);
}

}  // namespace ensonify
