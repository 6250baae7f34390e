// `ensonify fit`: keys of a scenario against a recording.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "cli/commands.h"
#include "compare/measure_blocks.h"
#include "compare/read_pings.h"
#include "dataset/layout.h"
#include "fit/fit_text.h"
#include "fit/moment_samples.h"
#include "formats/output_place.h"
#include "formats/sha256.h"
#include "run/program.h"
#include "run/simulate_pings.h"
#include "run/terminal.h"
#include "scenario/scenario.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

struct FitInput {
  std::vector<FitKey> keys;
  std::string identity;
  PolarPings recording;
  std::optional<Recorder> recorder;  // of the recording
  std::vector<std::string> notes;
};

Result<std::vector<FitKey>> keys_of(const FitOptions& options) {
  std::vector<FitKey> keys;
  for (const std::string& text : options.keys) {
    auto key = parse_key(text);
    if (!key) return key.error();
    const bool twice = std::any_of(keys.begin(), keys.end(),
                                   [&](const FitKey& other) { return other.path == key->path; });
    if (twice) return Error{ErrorKind::usage, "--key " + key->path + ": given twice"};
    keys.push_back(std::move(*key));
  }
  if (keys.size() > kMostFitKeys) {
    return Error{ErrorKind::usage,
                 fmt::format("--key: given {} times; expected up to {}", keys.size(), kMostFitKeys)};
  }
  return keys;
}

// The scenario with values of the keys.
ScenarioOptions with_values(const FitOptions& options, std::span<const FitKey> keys,
                            std::span<const double> values) {
  ScenarioOptions scenario = options.scenario;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    scenario.overrides.push_back({keys[k].path, key_text(values[k])});
  }
  return scenario;
}

std::vector<double> middle_of(std::span<const FitKey> keys) {
  std::vector<double> values;
  for (const FitKey& key : keys) values.push_back(key_value(key, 0.5));
  return values;
}

// Everything that the moments depend on.
Result<std::string> identity_of(const FitOptions& options, std::span<const FitKey> keys) {
  const ScenarioOptions scenario = with_values(options, keys, middle_of(keys));
  const auto loaded = load_scenario(scenario.scenario, scenario.overrides);
  if (!loaded) return loaded.error();
  const auto manifest = sha256_of_file(options.recording / layout::kDatasetJson);
  if (!manifest) return manifest.error();
  std::string text = to_yaml(*loaded, [](const fs::path& file) {
    const auto hash = sha256_of_file(file);
    return hash ? *hash : file.string();
  });
  for (const FitKey& key : keys) {
    text += fmt::format("{} {} {} {}\n", key.path, key.low, key.high, key.log);
  }
  std::string mask;
  if (!options.mask.empty()) {
    const auto hash = sha256_of_file(options.mask);
    if (!hash) return hash.error();
    mask = *hash;
  }
  text += fmt::format("{} {} {} {} {} {}", *manifest, options.amount.images, options.amount.blocks,
                      mask, program_version(), program_commit());
  return sha256_hex(text);
}

// The ends of all ranges, so that a bad range is known before the first simulation.
Status check_ranges(const FitOptions& options, std::span<const FitKey> keys) {
  for (std::size_t k = 0; k < keys.size(); ++k) {
    for (const double u : {0.0, 1.0}) {
      std::vector<double> values = middle_of(keys);
      values[k] = key_value(keys[k], u);
      const ScenarioOptions scenario = with_values(options, keys, values);
      const auto loaded = load_scenario(scenario.scenario, scenario.overrides);
      if (!loaded) return loaded.error();
    }
  }
  return {};
}

Result<FitInput> read_input(const FitOptions& options, const Workers& workers) {
  FitInput input;
  auto keys = keys_of(options);
  if (!keys) return keys.error();
  input.keys = std::move(*keys);
  if (!is_dataset(options.recording)) {
    return Error{ErrorKind::usage,
                 options.recording.string() + ": is not a data set; expected one, such as "
                                              "`ensonify import` makes of a log"};
  }
  if (const Status ranges = check_ranges(options, input.keys); !ranges) return ranges.error();
  auto identity = identity_of(options, input.keys);
  if (!identity) return identity.error();
  input.identity = std::move(*identity);
  auto read = read_pings({options.recording, options.amount, options.mask, {}, options.stop},
                         workers);
  if (!read) return read.error();
  if (read->pings.blocks() < 3) {
    return Error{ErrorKind::usage, options.recording.string() +
                                       ": has fewer than 3 blocks of pings, which errors need; "
                                       "expected more pings"};
  }
  input.recording = std::move(read->pings);
  input.recorder = read->recorder;
  input.notes = std::move(read->notes);
  return input;
}

Status prepare_folder(const FitOptions& options) {
  std::error_code error;
  const fs::path evaluations = options.output / "evaluations.jsonl";
  const bool is_there = fs::exists(options.output, error);
  if (is_there && !fs::is_empty(options.output, error) && !fs::exists(evaluations, error)) {
    return Error{ErrorKind::usage, options.output.string() +
                                       ": is not empty and not the folder of a fit; expected a "
                                       "new folder"};
  }
  if (options.overwrite) fs::remove(evaluations, error);
  fs::create_directories(options.output, error);
  if (error) return Error{ErrorKind::io, options.output.string() + ": " + error.message()};
  return {};
}

// Moments of simulations, by the settings of the comparison.
struct Simulator {
  const FitOptions& options;
  const FitInput& input;
  const MeasureSettings& settings;
  const Workers& workers;
  Evaluations& known;

  Result<MomentSample> operator()(std::span<const double> values) const {
    if (const MomentSample* sample = known.find(values)) return *sample;
    const ScenarioOptions scenario = with_values(options, input.keys, values);
    const auto pings =
        simulate_pings({scenario, options.amount, input.recorder, options.stop}, workers);
    if (!pings) return pings.error();
    MomentSample sample = moments_of(measure_pings(*pings, settings, workers));
    if (const Status added = known.add(values, sample); !added) return added.error();
    constexpr std::size_t kToldEvery = 20;
    if (!options.quiet && known.size() % kToldEvery == 0) tell("{} simulations\n", known.size());
    return sample;
  }
};

Result<Fit> run_fit(const FitOptions& options, const FitInput& input, FitFacts& facts,
                    const Workers& workers) {
  auto known = Evaluations::open(options.output / "evaluations.jsonl", input.identity);
  if (!known) return known.error();
  const ScenarioOptions scenario = with_values(options, input.keys, middle_of(input.keys));
  const auto middle =
      simulate_pings({scenario, options.amount, input.recorder, options.stop}, workers);
  if (!middle) return middle.error();
  if (input.recorder.has_value() != middle->from_counts) {
    tell("note: only the {} has counts of a recorder; steps, limits and gains of the other's levels "
         "are not those of an instrument\n",
         input.recorder ? "recording" : "scenario");
  }
  if (middle->blocks() < 3) {
    return Error{ErrorKind::usage, "the scenario has fewer than 3 blocks of pings, which errors "
                                   "need; expected more trajectory.pings or sequences"};
  }
  const MeasureSettings settings = common_settings(input.recording, *middle, workers);
  if (!(settings.range_to > settings.range_from) ||
      !(settings.azimuth_to > settings.azimuth_from)) {
    return Error{ErrorKind::usage, "scenario and recording have no ranges or no azimuths in common"};
  }
  const BlockStatistics measured = measure_pings(input.recording, settings, workers);
  facts.target = moments_of(measured);
  facts.moment_names = moment_names(measured);
  facts.pings = input.recording.amplitude.size();
  facts.blocks = input.recording.blocks();
  FitSettings search;
  search.max_evaluations = options.max_simulations;
  return fit_keys(input.keys, facts.target, search,
                  Simulator{options, input, settings, workers, *known});
}

}  // namespace

Status fit_command(FitOptions options) {
  listen_for_interrupts();
  options.stop = interrupted;
  const Workers workers(options.threads);
  auto input = read_input(options, workers);
  if (!input) return input.error();
  if (const Status ready = prepare_folder(options); !ready) return ready;
  for (const std::string& note : input->notes) tell("note: {}\n", note);
  FitFacts facts;
  facts.scenario = options.scenario.scenario.string();
  facts.recording = options.recording.string();
  const auto fit = run_fit(options, *input, facts, workers);
  if (!fit) return fit.error();
  const std::pair<const char*, std::string> files[] = {
      {"fit.json", fit_json(input->keys, *fit, facts)},
      {"card.yaml", fit_card(input->keys, *fit, facts)}};
  for (const auto& [name, text] : files) {
    if (const Status written = write_whole(options.output / name, text); !written) return written;
  }
  if (!options.quiet) answer("{}", fit_table(input->keys, *fit));
  return {};
}

}  // namespace ensonify
