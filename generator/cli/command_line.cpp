#include "run/program.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <new>
#include <sstream>
#include <system_error>

#include "cli/command_line_views.h"
#include "cli/commands.h"
#include "cli/help_format.h"
#include "cli/usage_errors.h"
#include "run/terminal.h"

namespace ensonify {
namespace {

const std::map<std::string, BackendChoice>& backends() {
  static const std::map<std::string, BackendChoice> all = {{"auto", BackendChoice::automatic},
                                                           {"cpu", BackendChoice::cpu},
                                                           {"cuda", BackendChoice::cuda},
                                                           {"reference", BackendChoice::reference}};
  return all;
}

// Everything that the command line can contain; each command reads its own part.
struct Arguments {
  std::string scenario, folder, pings, sequences, backend = "auto", simd = "auto";
  std::vector<std::string> sets;
  std::optional<std::string> seed, speckle_seed, preset;
  bool all_worlds = false;
  int threads = 0;
  BenchCommandOptions bench;
  ViewArguments views;
  std::string shard;
  bool list = false, status = false, finalize = false, partial = false;
  bool overwrite = false, export_scatterers = false, quiet = false;
  bool ignore_free_space = false;
};

Result<int> exit_status(const Status& status) {
  if (!status) return status.error();
  return 0;
}

Error usage(const std::string& text) { return {ErrorKind::usage, text}; }

Result<std::vector<Override>> overrides_of(const std::vector<std::string>& sets) {
  std::vector<Override> overrides;
  for (const std::string& set : sets) {
    const std::size_t equals = set.find('=');
    if (equals == std::string::npos || equals == 0) {
      return usage(fmt::format("--set {}: no value; expected KEY.PATH=VALUE", set));
    }
    overrides.push_back({set.substr(0, equals), set.substr(equals + 1)});
  }
  return overrides;
}

Result<ScenarioOptions> scenario_options(const Arguments& arguments) {
  Result<std::vector<Override>> overrides = overrides_of(arguments.sets);
  if (!overrides) return overrides.error();
  if (arguments.seed) overrides->push_back({"seed", *arguments.seed});
  if (arguments.speckle_seed) overrides->push_back({"speckle_seed", *arguments.speckle_seed});
  if (arguments.export_scatterers) overrides->push_back({"output.scatterers", "true"});
  return ScenarioOptions{arguments.scenario, std::move(*overrides)};
}

Result<SimdLevel> simd_of(const Arguments& arguments) {
  if (arguments.simd == "auto") return best_simd_level();
  const SimdLevel level = *parse_simd_level(arguments.simd);
  if (level <= best_simd_level()) return level;
  return usage(
      fmt::format("--simd {}: this processor does not support it; expected auto or up to {}",
                  arguments.simd, simd_level_name(best_simd_level())));
}

Status set_make_options(const Arguments& arguments, MakeOptions& options) {
  options.output = arguments.folder;
  options.threads = arguments.threads;
  options.backend = backends().at(arguments.backend);
  options.overwrite = arguments.overwrite;
  options.partial = arguments.partial;
  options.quiet = arguments.quiet;
  options.ignore_free_space = arguments.ignore_free_space;
  const Result<SimdLevel> simd = simd_of(arguments);
  if (!simd) return simd.error();
  options.simd = *simd;
  if (arguments.shard.empty()) return {};
  const Result<Shard> shard = parse_shard(arguments.shard);
  if (!shard) return shard.error();
  options.shard = *shard;
  return {};
}

Status run_generate(const Arguments& arguments) {
  Result<ScenarioOptions> input = scenario_options(arguments);
  if (!input) return input.error();
  GenerateOptions options;
  options.input = std::move(*input);
  if (arguments.folder.empty()) return usage("--output: the name is empty; expected a folder");
  if (!arguments.pings.empty()) {
    const auto range = parse_range("--pings", arguments.pings);
    if (!range) return range.error();
    options.pings = *range;
  }
  if (!arguments.sequences.empty()) {
    const auto range = parse_range("--sequences", arguments.sequences);
    if (!range) return range.error();
    options.sequences = *range;
  }
  if (Status set = set_make_options(arguments, options); !set) return set;
  return arguments.finalize ? finalize_dataset(options) : generate(options);
}

Status run_check(const Arguments& arguments) {
  Result<ScenarioOptions> input = scenario_options(arguments);
  if (!input) return input.error();
  const Result<SimdLevel> simd = simd_of(arguments);
  if (!simd) return simd.error();
  return check({std::move(*input), arguments.folder, arguments.threads,
                backends().at(arguments.backend), *simd, arguments.all_worlds});
}

// Returns the exit status.
Result<int> run_sweep_command(const Arguments& arguments) {
  SweepOptions options;
  options.sweep = arguments.scenario;
  Result<std::vector<Override>> overrides = overrides_of(arguments.sets);
  if (!overrides) return overrides.error();
  options.overrides = std::move(*overrides);
  if (Status set = set_make_options(arguments, options); !set) return set.error();
  const bool makes_pings = !arguments.list && !arguments.status && !arguments.finalize;
  if (!makes_pings && (arguments.backend != "auto" || arguments.simd != "auto")) {
    return usage(
        "--backend and --simd have no effect with --list, --status and --finalize, which make no "
        "runs");
  }
  if (arguments.list) return exit_status(list_sweep(options));
  if (arguments.folder.empty()) return usage("--output: missing; expected a folder");
  if (arguments.status) return exit_status(sweep_status(options));
  if (arguments.finalize) return exit_status(finalize_sweep(options));
  const Result<std::size_t> failed = run_sweep(options);
  if (!failed) return failed.error();
  return *failed > 0 ? exit_code(ErrorKind::incomplete) : 0;
}

CLI::Option* add_set(CLI::App& command, Arguments& arguments, const std::string& key) {
  return command
      .add_option(
          "--set", arguments.sets,
          "KEY.PATH=VALUE: override " + key + "; name items of a list by index (objects.0.name)")
      ->allow_extra_args(false);
}

void add_scenario_arguments(CLI::App& command, Arguments& arguments) {
  command
      .add_option("SCENARIO", arguments.scenario, "scenario file (YAML), or - for standard input")
      ->required();
  add_set(command, arguments, "a key");
  command.add_option("--seed", arguments.seed, "override the seed of the scenario");
  command.add_option("--speckle-seed", arguments.speckle_seed,
                     "override the speckle seed, which samples nothing but the speckle again");
}

void add_numerics(CLI::App& command, Arguments& arguments) {
  command.add_option("--threads", arguments.threads, "threads; 0 uses all cores")
      ->check(CLI::Range(0, 4096));
  command
      .add_option("--backend", arguments.backend,
                  "auto (a CUDA device if available, else cpu), cpu, cuda, or reference (term by "
                  "term in double precision, seconds per ping)")
      ->check(CLI::IsMember(backends()));
  command
      .add_option("--simd", arguments.simd,
                  "vector instructions of the inner loops: auto (the best of this processor), "
                  "sse4, avx2 or avx512")
      ->check(CLI::IsMember({"auto", "sse4", "avx2", "avx512"}));
}

void add_ignore_free_space(CLI::App& command, Arguments& arguments) {
  command.add_flag("--ignore-free-space", arguments.ignore_free_space,
                   "start even if the disk has too little free space");
}

void add_sweep(CLI::App& app, Arguments& arguments) {
  CLI::App& command = *app.add_subcommand("sweep", "make the missing runs of a parameter sweep");
  command.add_option("SWEEP", arguments.scenario, "sweep file (YAML)")->required();
  command.add_option("-o,--output", arguments.folder, "folder of the sweep");
  CLI::Option* list = command.add_flag("--list", arguments.list,
                                       "print the runs with their cost and write nothing");
  CLI::Option* status =
      command.add_flag("--status", arguments.status, "print the progress of the sweep")
          ->excludes(list);
  CLI::Option* finalize = command
                              .add_flag("--finalize", arguments.finalize,
                                        "write runs.csv and index.json when all runs are done")
                              ->excludes(list)
                              ->excludes(status);
  command.add_flag("--partial", arguments.partial, "finish even if runs are missing")
      ->needs(finalize);
  add_set(command, arguments, "a key of the base in every run")
      ->excludes(status)
      ->excludes(finalize);
  command
      .add_option("--shard", arguments.shard,
                  "K/N: make only part K of N, starting with 0/N; default in a Slurm array: the "
                  "part of the task")
      ->excludes(finalize);
  add_numerics(command, arguments);
  command
      .add_flag("--overwrite", arguments.overwrite,
                "use the new plan and restart unfinished runs of other programs or machines; "
                "finished runs stay")
      ->excludes(status)
      ->excludes(finalize);
  add_ignore_free_space(command, arguments);
  command.add_flag("--quiet", arguments.quiet, "print no progress");
}

CLI::App& add_generate(CLI::App& app, Arguments& arguments) {
  CLI::App& command = *app.add_subcommand("generate", "make a data set, or resume one");
  add_scenario_arguments(command, arguments);
  command.add_option("-o,--output", arguments.folder, "folder of the data set")->required();
  command.add_option("--pings", arguments.pings, "A:B: make only pings A to B-1 of every sequence");
  CLI::Option* sequences =
      command.add_option("--sequences", arguments.sequences, "A:B: make only sequences A to B-1");
  CLI::Option* shard = command
                           .add_option("--shard", arguments.shard,
                                       "K/N: make only the sequences of part K of N, starting with "
                                       "0/N; --finalize completes the data set")
                           ->excludes(sequences);
  CLI::Option* overwrite =
      command.add_flag("--overwrite", arguments.overwrite,
                       "replace another data set; removes only files that its manifest lists");
  CLI::Option* finalize =
      command
          .add_flag(
              "--finalize", arguments.finalize,
              "make no sequences; write the index of the data set when all sequences are made")
          ->excludes(sequences)
          ->excludes(shard)
          ->excludes(overwrite);
  command.add_flag("--partial", arguments.partial, "finish even if sequences are missing")
      ->needs(finalize);
  add_numerics(command, arguments);
  add_ignore_free_space(command, arguments);
  command.add_flag("--export-scatterers", arguments.export_scatterers,
                   "also write scatterers/*.npy");
  command.add_flag("--quiet", arguments.quiet, "print no progress");
  return command;
}

void add_check(CLI::App& app, Arguments& arguments) {
  CLI::App& command =
      *app.add_subcommand("check", "validate a scenario; print its resolved text and its cost");
  add_scenario_arguments(command, arguments);
  command.add_option("-o,--output", arguments.folder,
                     "folder on the disk whose free space is printed; default: the current folder");
  command.add_flag("--all", arguments.all_worlds,
                   "build the worlds of all sequences; default: up to 200");
  add_numerics(command, arguments);
}

void add_bench(CLI::App& app, Arguments& arguments) {
  BenchCommandOptions& options = arguments.bench;
  CLI::App& command = *app.add_subcommand(
      "bench", "measure the speed of this machine in making whole data sets, from scene to disk");
  CLI::Option* scenario =
      command.add_option("SCENARIO", arguments.scenario, "measure only data sets of this scenario");
  add_set(command, arguments, "a key of the scenario")->needs(scenario);
  command.add_option("--json", options.json, "also write the numbers to this file");
  command
      .add_option(
          "--only", options.only,
          "measure only this table, and others by further --only: series (time series alone, with "
          "their error), files (by kind of file), scenes (shipped ones), features (a plain scene "
          "with one more each), ensemble (realizations of one scene), and growth with threads, "
          "beams, samples, rays, objects and triangles; default: all")
      ->allow_extra_args(false)
      ->check(CLI::IsMember(bench_group_names()))
      ->excludes(scenario);
  command.add_option("--threads", options.threads, "threads; 0 uses all cores")
      ->check(CLI::Range(0, 4096));
  command
      .add_option("--pings", options.pings,
                  fmt::format("minimum number of pings in a data set, with more sequences if a "
                              "scenario has fewer; default: {}",
                              options.pings))
      ->check(CLI::Range(1, 100'000));
  command.add_option("--disk", options.disk,
                     "folder for temporary files; default: a new temporary folder");
}

Status run_bench_command(const Arguments& arguments) {
  Result<ScenarioOptions> input = scenario_options(arguments);
  if (!input) return input.error();
  BenchCommandOptions options = arguments.bench;
  options.input = std::move(*input);
  return bench(options);
}

// The command that was given, with its arguments filled in; otherwise the parser's exit status.
Result<int> dispatch(const CLI::App& app, const Arguments& arguments) {
  if (app.got_subcommand("sweep")) return run_sweep_command(arguments);
  if (app.got_subcommand("generate")) return exit_status(run_generate(arguments));
  if (app.got_subcommand("check")) return exit_status(run_check(arguments));
  if (app.got_subcommand("verify")) {
    return exit_status(verify(arguments.folder, arguments.threads));
  }
  if (app.got_subcommand("export")) return exit_status(run_export(arguments.views));
  if (app.got_subcommand("render")) return exit_status(run_render(arguments.views));
  if (app.got_subcommand("import")) return exit_status(run_import(arguments.views));
  if (app.got_subcommand("bench")) return exit_status(run_bench_command(arguments));
  if (app.got_subcommand("report")) return exit_status(run_report(arguments.views));
  if (app.got_subcommand("compare")) return exit_status(run_compare(arguments.views));
  if (app.got_subcommand("figure")) return exit_status(run_figure(arguments.views));
  if (app.got_subcommand("preview") || app.got_subcommand("fit")) {
    Result<ScenarioOptions> input = scenario_options(arguments);
    if (!input) return input.error();
    const bool fits = app.got_subcommand("fit");
    return exit_status(fits ? run_fit(std::move(*input), arguments.views)
                            : run_preview(std::move(*input), arguments.views));
  }
  return exit_status(presets(arguments.preset));
}

int report(const Error& error) {
  tell("{}\n", error.message);
  return exit_code(error.kind);
}

// Whether this is the error of std::thread, or that of TBB, which has only these words, when the
// system cannot start a thread.
bool is_refused_thread(const std::exception& error) {
  if (const auto* system = dynamic_cast<const std::system_error*>(&error)) {
    return system->code() == std::errc::resource_unavailable_try_again;
  }
  return std::string_view(error.what()).starts_with("pthread_create");
}

// The exit status of a successful command, unless its output could not be written.
int ended_with(int status) {
  const Status written = answers_written();
  return status == 0 && !written ? report(written.error()) : status;
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  Arguments arguments;
  CLI::App app("ensonify: labeled multibeam sonar data sets from YAML scenarios", "ensonify");
  app.set_version_flag("--version",
                       fmt::format("ensonify {} ({})", program_version(), program_commit()));
  add_help_format(app, program_version());
  app.require_subcommand(1);
  add_generate(app, arguments);
  add_check(app, arguments);
  CLI::App& verify_command =
      *app.add_subcommand("verify", "check a data set or a sweep: schema, shapes, checksums");
  verify_command.add_option("DIR", arguments.folder, "folder of a data set or a sweep")->required();
  verify_command.add_option("--threads", arguments.threads, "threads; 0 uses all cores")
      ->check(CLI::Range(0, 4096));
  add_import(app, arguments.views);
  add_export(app, arguments.views);
  add_render(app, arguments.views);
  add_report(app, arguments.views);
  add_compare(app, arguments.views);
  CLI::App& fit =
      *app.add_subcommand("fit", "fit keys of a scenario to the statistics of a recording");
  add_scenario_arguments(fit, arguments);
  add_fit(fit, arguments.views);
  add_figure(app, arguments.views);
  add_scenario_arguments(add_preview(app, arguments.views), arguments);
  add_sweep(app, arguments);
  add_bench(app, arguments);
  add_presets(app, arguments.preset);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::ostringstream answered, told;
    const int status = app.exit(error, answered, told);
    answer("{}", answered.str());
    if (status == 0) return ended_with(0);
    return report({ErrorKind::usage, usage_error_text(app, error)});
  }
  try {
    const Result<int> status = dispatch(app, arguments);
    return status ? ended_with(*status) : report(status.error());
  } catch (const std::bad_alloc&) {
    return report({ErrorKind::device,
                   "not enough memory; `ensonify check` prints what a scenario needs, and fewer "
                   "rays or beams or a shorter range need less"});
  } catch (const DeviceFailure& failure) {
    return report({ErrorKind::device, failure.what()});
  } catch (const std::exception& error) {
    if (is_refused_thread(error)) {
      return report({ErrorKind::device,
                     "the system cannot start more threads; give fewer --threads or raise the "
                     "limit (ulimit -u, pids.max of a container)"});
    }
    return report({ErrorKind::bug, fmt::format("bug: {}; please report it", error.what())});
  }
}

}  // namespace ensonify
