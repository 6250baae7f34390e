#include <algorithm>
#include <fstream>
#include <iterator>
#include <system_error>

#include <fmt/format.h>

#include "scenario/draw.h"
#include "scenario/drawn_sections.h"
#include "scenario/merge.h"
#include "scenario/parse.h"
#include "scenario/scenario_tree.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr int kMaxSequences = 1'000'000;
constexpr int kMaxImageHeight = 16384;
constexpr int kMaxSdfBand = 100;

// Labels that go with pictures: on where there are polar or Cartesian ones.
void parse_hidden_labels(Faults& faults, const Value& value, OutputSelection& selection) {
  const bool with_labels = selection.polar || selection.cartesian;
  const auto read = [&](const char* key, bool possible, const char* pictures, bool& wanted) {
    wanted = with_labels;
    const auto map = read_switch(faults, value, key, wanted);
    if (map) open_map(faults, *map, {});
    const auto given = child(value, key);
    if (!given || !wanted || possible) return;
    add_fault(faults, given->place, given->path,
              fmt::format("there are no pictures for it, accepted with {}", pictures));
  };
  read("shadow", with_labels, "polar or cartesian", selection.shadow);
  read("amodal", with_labels || selection.png, "polar, cartesian or png", selection.amodal);
}

void parse_sdf(Faults& faults, const Value& value, OutputSpec& output) {
  bool wanted = false;
  const auto map = read_switch(faults, value, "sdf", wanted);
  if (!wanted) return;
  SdfGrid& sdf = output.sdf.emplace();
  if (!map) {
    const Value sdf_value = *child(value, "sdf");
    add_fault(faults, sdf_value.place, path_of(sdf_value, "voxel_m"),
              "missing, accepted is a map with it, as in {voxel_m: 0.05}");
    return;
  }
  if (!open_map(faults, *map, {"voxel_m", "band_voxels"})) return;
  read_number(faults, *map, "voxel_m", above_up_to(0, kMaxLengthM), sdf.voxel_m, Need::required);
  read_integer(faults, *map, "band_voxels", 1, kMaxSdfBand, sdf.band_voxels);
}

// The head of a scenario.
void parse_head(Faults& faults, const Value& root, Scenario& scenario) {
  int version = 0;
  read_integer(faults, root, "ensonify", 1, 1, version, Need::required);
  read_text(faults, root, "name", scenario.name);
  read_seed(faults, root, "seed", scenario.seed);
  int sequences = 1;
  read_integer(faults, root, "sequences", 1, kMaxSequences, sequences);
  scenario.sequences = static_cast<std::uint32_t>(sequences);
}

void parse_noise(Faults& faults, const Value& value, Scenario& scenario) {
  if (!open_map(faults, value, {"spectrum_level_db", "snr_db"})) return;
  const auto key = only_key_of(faults, value, {"spectrum_level_db", "snr_db"},
                               "either alone: spectrum_level_db (dB re 1 uPa^2/Hz) or snr_db (dB)");
  double level = 0;
  if (key == "spectrum_level_db") {
    if (read_number(faults, value, *key, from_to(-300, 300), level)) {
      scenario.noise_spectrum_level_db = level;
    }
  } else if (key == "snr_db" && read_number(faults, value, *key, from_to(-100, 200), level)) {
    scenario.noise_snr_db = level;
  }
}

// A scenario without a name is called after its file.
std::string default_name(const std::string& label) {
  const std::string stem = std::filesystem::path(label).stem().string();
  const bool printable = !first_invalid_utf8(stem) && !first_control_character(stem, "");
  return printable && !stem.empty() && stem.size() <= kMaxNameBytes ? stem : "scenario";
}

bool same_place(const Place& a, const Place& b) {
  return a.source == b.source && a.line == b.line && a.column == b.column;
}

// A distribution that cannot be drawn has its fault: that it is no number need not be said as well.
void drop_faults_at(const std::vector<Place>& places, std::size_t first, Faults& faults) {
  const auto begin = faults.list.begin() + static_cast<std::ptrdiff_t>(first);
  const auto told = [&](const Fault& fault) {
    return std::any_of(places.begin(), places.end(),
                       [&](const Place& place) { return same_place(place, fault.place); });
  };
  faults.list.erase(std::remove_if(begin, faults.list.end(), told), faults.list.end());
}

Scenario read_scenario(const InputFolder& input, const Value& root, const std::string& label) {
  Faults& faults = input.faults;
  Scenario scenario;
  scenario.name = default_name(label);
  scenario.trajectory.pings = 1;
  if (const auto sweep = child(root, "ensonify_sweep")) {
    add_fault(faults, sweep->place, sweep->path,
              "this is a sweep, accepted is a scenario; `ensonify sweep` takes it");
    return scenario;
  }
  open_map(faults, root,
           {"ensonify", "name", "seed", "sequences", "sonar", "water", "scattering", "materials",
            "objects", "point_targets", "volumes", "multipath", "trajectory", "motion_within_ping",
            "noise", "synthesis", "output", "splits"});
  parse_head(faults, root, scenario);
  parse_sonar(input, child_or_empty(root, "sonar"), scenario.sonar);
  if (const auto v = child(root, "water")) parse_water(input, *v, scenario.water);
  if (const auto v = child(root, "scattering")) parse_scattering(faults, *v, scenario.scattering);
  if (const auto v = child(root, "materials")) parse_materials(input, *v, scenario.materials);
  if (const auto v = child(root, "objects")) {
    parse_objects(input, *v, scenario.materials, scenario.objects);
  }
  if (const auto v = child(root, "point_targets")) {
    parse_point_targets(faults, *v, scenario.point_targets);
  }
  if (const auto v = child(root, "volumes")) parse_volumes(input, *v, scenario.volumes);
  if (const auto v = child(root, "multipath")) {
    parse_multipath(faults, *v, scenario.multipath.emplace());
  }
  check_instances(faults, root);
  parse_trajectory(input, child_or_empty(root, "trajectory"), scenario.trajectory);
  read_boolean(faults, root, "motion_within_ping", scenario.motion_within_ping);
  if (const auto v = child(root, "noise")) parse_noise(faults, *v, scenario);
  if (const auto v = child(root, "synthesis"); v && open_map(faults, *v, {"tolerance"})) {
    read_number(faults, *v, "tolerance", from_to(1e-7, 1e-3), scenario.synthesis_tolerance);
  }
  if (const auto v = child(root, "output")) parse_output(faults, *v, scenario.output);
  parse_multipath_mask(faults, root, scenario);
  if (const auto v = child(root, "splits")) parse_splits(faults, *v, scenario.splits);
  check_array(faults, root, scenario);
  check_ping_size(faults, root, scenario);
  check_burst_length(faults, root, scenario);
  check_profile_conflicts(faults, root, scenario);
  return scenario;
}

}  // namespace

void parse_scattering(Faults& faults, const Value& value, ScatteringSpec& scattering) {
  if (!open_map(faults, value, {"lambert_exponent", "normalization", "speckle"})) return;
  read_number(faults, value, "lambert_exponent", kLambertExponent, scattering.lambert_exponent);
  read_choice<Normalization>(
      faults, value, "normalization",
      {{"calibrated", Normalization::calibrated}, {"mean_square", Normalization::mean_square}},
      scattering.normalization);
  read_choice<SpeckleMode>(faults, value, "speckle",
                           {{"per_ping", SpeckleMode::per_ping},
                            {"per_ray", SpeckleMode::per_ray},
                            {"surface", SpeckleMode::surface}},
                           scattering.speckle);
}

void parse_output(Faults& faults, const Value& value, OutputSpec& output) {
  if (!open_map(
          faults, value,
          {"timeseries", "polar", "cartesian", "png", "shadow", "amodal", "multipath", "polygons",
           "scatterers", "points", "layers", "channels", "pack", "sdf", "statistics", "pings"})) {
    return;
  }
  OutputSelection& selection = output.selection;
  const auto read_plain_switch = [&](const char* key, bool& wanted) {
    if (const auto map = read_switch(faults, value, key, wanted)) open_map(faults, *map, {});
  };
  parse_timeseries(faults, value, selection);
  read_plain_switch("polar", selection.polar);
  if (const auto map = read_switch(faults, value, "cartesian", selection.cartesian);
      map && open_map(faults, *map, {"height_px"})) {
    read_integer(faults, *map, "height_px", 1, kMaxImageHeight, output.cartesian_height_px);
  }
  parse_png(faults, value, output);
  parse_hidden_labels(faults, value, selection);
  read_plain_switch("polygons", selection.polygons);
  read_plain_switch("scatterers", selection.scatterers);
  read_plain_switch("points", selection.points);
  parse_layers(faults, value, output);
  read_plain_switch("channels", selection.channels);
  parse_pack(faults, value, selection);
  parse_sdf(faults, value, output);
  read_plain_switch("statistics", selection.statistics);
  parse_pings(faults, value, selection);
}

void parse_splits(Faults& faults, const Value& value, SplitsSpec& splits) {
  if (!open_map(faults, value, {"train", "val", "test"})) return;
  const std::size_t before = faults.found();
  const NumberRange fraction = from_to(0, 1e6);
  splits = {0, 0, 0};
  read_number(faults, value, "train", fraction, splits.train);
  read_number(faults, value, "val", fraction, splits.val);
  read_number(faults, value, "test", fraction, splits.test);
  if (faults.found() == before && !(splits.train + splits.val + splits.test > 0)) {
    add_fault(faults, value.place, value.path,
              "the fractions train, val and test are all zero, accepted is a sum above zero");
  }
}

namespace {

// Whoever runs a stranger's scenario wants to know what of his own it reads.
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
        "{} lies outside the scenario's folder; its bytes go into the data set", found.string())));
  }
  return notices;
}

}  // namespace

std::optional<Scenario> parse_scenario_tree(Node tree, const std::string& label,
                                            const std::filesystem::path& folder, Faults& faults,
                                            std::uint32_t sequence) {
  const InputFolder input{folder, faults};
  const Value root{&tree, tree.place, ""};
  auto sections = keep_drawn_sections(tree, input);
  const bool drawn = holds_distribution(tree);
  std::vector<std::string> classes = class_names(root);
  const std::vector<std::string> targets = layer_target_words(root);
  std::uint64_t seed = 0;
  Faults told_later;
  read_seed(told_later, root, "seed", seed);
  std::vector<Place> wrong;
  std::vector<DrawnValue> draws;
  draw_values(tree, seed, sequence, faults, wrong, draws);
  const std::size_t before = faults.list.size();
  Scenario scenario = read_scenario(input, root, label);
  check_layer_targets(faults, root, targets);
  drop_faults_at(wrong, before, faults);
  if (!faults.empty()) return std::nullopt;
  scenario.has_draws = drawn || std::any_of(scenario.objects.begin(), scenario.objects.end(),
                                            [](const ObjectSpec& o) { return o.place; });
  scenario.draws = std::move(draws);
  scenario.class_names = std::move(classes);
  scenario.drawn_sections = std::move(sections);
  scenario.notices = notices_of_files(scenario, folder);
  return scenario;
}

Result<Scenario> parse_scenario(const std::string& text, const std::string& label,
                                const std::filesystem::path& folder,
                                const std::vector<Override>& overrides, std::uint32_t sequence,
                                const ReadLimits& limits) {
  Faults faults;
  faults.limits = limits;
  std::optional<Node> tree = read_yaml_map(text, add_source(faults, label), faults);
  if (!tree) return to_error(faults);
  apply_overrides(*tree, overrides, faults);
  auto scenario = parse_scenario_tree(std::move(*tree), label, folder, faults, sequence);
  if (!scenario) return to_error(faults);
  return std::move(*scenario);
}

Result<std::string> read_scenario_text(const std::filesystem::path& file, std::string_view what) {
  const std::string label = file.string();
  const auto refuse = [&](ErrorKind kind, const std::string& trouble) {
    return Error{kind,
                 one_line(fmt::format("{}: {}, accepted is {} in YAML", label, trouble, what))};
  };
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
  // One byte more than the limit, so that an endless pipe ends and is refused.
  std::string text(kMaxYamlBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) return refuse(ErrorKind::io, "cannot be read");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

Result<Scenario> load_scenario(const std::filesystem::path& file,
                               const std::vector<Override>& overrides, std::uint32_t sequence) {
  const Result<std::string> text = read_scenario_text(file);
  if (!text) return text.error();
  return parse_scenario(*text, file.string(), file.parent_path(), overrides, sequence);
}

}  // namespace ensonify
