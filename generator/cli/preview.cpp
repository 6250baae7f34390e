#include <fmt/format.h>

#include <stdlib.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <system_error>

#include "cli/commands.h"
#include "cli/preview_parts.h"
#include "core/counted.h"
#include "core/parallel.h"
#include "dataset/finish.h"
#include "dataset/work.h"
#include "dataset/write_ping.h"
#include "formats/files.h"
#include "formats/sha256.h"
#include "ping/object_looks.h"
#include "ping/pipeline.h"
#include "ping/prepare_session.h"
#include "ping/scene_warnings.h"
#include "ping/sequence_info.h"
#include "ping/session.h"
#include "run/make_dataset.h"
#include "run/program.h"
#include "run/terminal.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// A prepared preview, of which nothing is written yet. Its parts refer to each other.
struct Preview {
  Scenario scenario;  // complete, before it is reduced
  Session session;
  std::unique_ptr<Tracer> tracer;
  std::optional<Pipeline> pipeline;
  PingStart ping_zero;
  Numerics numerics;
  std::vector<std::uint32_t> pings;
};

using FolderName = std::shared_ptr<const fs::path>;

// A temporary folder that is removed with its content when the last reference to it is destroyed.
Result<FolderName> temporary_folder() {
  std::error_code error;
  const fs::path place = fs::temp_directory_path(error);
  if (error) {
    return Error{ErrorKind::io,
                 fmt::format("there is no folder for temporary files: {}; expected one in TMPDIR",
                             error.message())};
  }
  std::string name = (place / "ensonify-preview-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) return write_error(name, errno);
  return FolderName(new fs::path(name), [](const fs::path* folder) {
    std::error_code ignored;
    fs::remove_all(*folder, ignored);
    delete folder;
  });
}

Status unless_interrupted() {
  if (!interrupted()) return {};
  return Error{ErrorKind::interrupted, "interrupted"};
}

std::string plain_text(const Scenario& scenario) {
  return to_yaml(scenario, [](const fs::path& file) { return file.string(); });
}

// The scenario as sampled.
Result<Scenario> scenario_of(const PreviewOptions& options, const std::string& text,
                             SequenceDraw draw) {
  const ScenarioOptions& input = options.input;
  Result<Scenario> scenario = parse_scenario(text, input.scenario.string(),
                                             input.scenario.parent_path(), input.overrides, draw);
  if (!scenario) return scenario;
  if (Status can = need_sonar(*scenario); !can) return can.error();
  if (options.sequence < scenario->sequences) return scenario;
  return Error{ErrorKind::usage, fmt::format("--sequence {}: the scenario has sequences 0 to {}",
                                             options.sequence, scenario->sequences - 1)};
}

void tell_reduction(const PreviewOptions& options, const Preview& preview) {
  if (options.quiet) return;
  std::string sequence;
  if (preview.scenario.sequences > 1) {
    sequence = fmt::format(" of sequence {} of {}", options.sequence, preview.scenario.sequences);
  }
  tell("preview: {} of {}{}, {}\n", preview.pings.size(),
       counted(preview.session.ping_times_s.size(), "ping"), sequence,
       reduction_text(preview.scenario, preview.session.scenario));
}

void warn(const PreviewOptions& options, const Preview& preview, const Workers& workers) {
  std::vector<std::string> warnings = preview.session.world.warnings;
  for (auto& text : scene_warnings(preview.session)) warnings.push_back(std::move(text));
  // Warnings about too few rays are left out if the rays were reduced.
  if (options.full) {
    for (auto& text : gap_warnings(preview.session, *preview.tracer, workers)) {
      warnings.push_back(std::move(text));
    }
  }
  for (const std::string& text : warnings) tell("warning: {}\n", text);
}

// Prints the levels of each object at ping 0, and objects that are never in view.
void tell_looks(const PreviewOptions& options, const Preview& preview, const Workers& workers) {
  const auto looks = look_at_objects(preview.session, *preview.tracer, options.sequence,
                                     preview.numerics, workers);
  if (!looks) return;  // noise.snr_db without an echo, which making the pings reports
  if (!options.quiet) {
    for (const std::string& line : look_lines(*looks)) tell("  {}\n", line);
  }
  if (preview.scenario.has_draws) return;  // another sequence may have it in view
  SeenObjects seen;
  note_seen(preview.session, *preview.tracer, options.sequence, *looks, workers, seen);
  for (const std::string& text : unseen_warnings(seen, preview.scenario)) {
    tell("warning: {}\n", text);
  }
}

// Errors of the scenario. `watch` gets the files that it names before they are read.
Result<std::unique_ptr<Preview>> prepare(const PreviewOptions& options, const Workers& workers,
                                         FileWatch* watch) {
  const fs::path& file = options.input.scenario;
  const Result<std::string> text = read_scenario_text(file);
  if (!text) return text.error();
  auto preview = std::make_unique<Preview>();
  const auto draw = [&](SequenceDraw of) {
    Result<Scenario> scenario = scenario_of(options, *text, of);
    if (!scenario) return scenario;
    if (watch != nullptr && of.redraw == 0) {
      std::vector<fs::path> files = input_files(*scenario);
      files.push_back(file);
      watch->watch(files);
    }
    preview->scenario = *scenario;
    return scenario;
  };
  Result<Session> session = drawn_session(
      {draw,
       [&](const Scenario& scenario, std::uint32_t sequence) {
         Result<Session> made = prepare_session(reduced_scenario(scenario, options.full), sequence);
         if (made) return made;
         return Result<Session>(
             with_place(made.error(), *text, file.string(), options.input.overrides));
       }},
      options.sequence);
  if (!session) return as_usage(session.error());
  preview->session = std::move(*session);
  // Nothing takes longer than a few pings, so starting a device is not worthwhile.
  Result<Numerics> numerics = settle_backend(BackendChoice::cpu, best_simd_level());
  if (!numerics) return numerics.error();
  preview->numerics = std::move(*numerics);
  const auto all = static_cast<std::uint32_t>(preview->session.ping_times_s.size());
  preview->pings = spread_pings(all, options.pings);
  preview->tracer = std::make_unique<Tracer>(preview->session.world);
  tell_reduction(options, *preview);
  warn(options, *preview, workers);
  tell_looks(options, *preview, workers);

  const auto shown = static_cast<std::uint32_t>(preview->pings.size());
  SharedParts shared;
  Result<ReadyPipeline> ready =
      make_pipeline(preview->session, *preview->tracer,
                    sequence_info(preview->session, options.sequence, 0, shown), preview->numerics,
                    workers, shared, true);
  if (!ready) return ready.error();
  preview->pipeline.emplace(std::move(ready->pipeline));
  preview->ping_zero = std::move(ready->ping_zero);
  return preview;
}

WorkIdentity preview_identity(const Preview& preview) {
  WorkIdentity identity;
  identity.name = preview.scenario.name;
  identity.scenario_sha256 = sha256_hex(plain_text(preview.scenario));
  identity.seed = preview.scenario.seed;
  identity.last_ping = preview.pipeline->info().last_ping;
  identity.program_version = program_version();
  identity.program_commit = program_commit();
  identity.backend = preview.numerics.backend_name;
  identity.simd = numerics_name(preview.numerics.simd);
  identity.embree_isa = preview.tracer->instruction_set();
  return identity;
}

// The pings of a data set are numbered consecutively; the random values, time and pose of each are
// those of its number in the run.
Status make_preview_pings(Preview& preview, const fs::path& folder, const Workers& workers) {
  const SequenceInfo& info = preview.pipeline->info();
  for (std::uint32_t i = 0; i < preview.pings.size(); ++i) {
    if (Status go = unless_interrupted(); !go) return go;
    PingStart start;
    if (preview.pings[i] == 0) start = std::move(preview.ping_zero);
    PingResult result = preview.pipeline->run(preview.pings[i], workers, std::move(start));
    result.ping = i;
    if (Status stored = write_ping(folder, info, result, workers); !stored) return stored;
  }
  return finish_sequence(folder, info, {.cartesian_map = preview.pipeline->cartesian_map()});
}

// The data set has no copies of the input files, because a preview does not need them.
Status make_data_set(Preview& preview, const fs::path& folder, const Workers& workers) {
  DatasetInfo dataset;
  dataset.identity = preview_identity(preview);
  dataset.scenario_yaml = plain_text(preview.scenario);
  dataset.first = preview.pipeline->info();
  dataset.sequences = {dataset.first.sequence};
  dataset.sequences_in_all = 1;
  dataset.classes = preview.session.world.classes;
  dataset.class_kinds = preview.scenario.class_kinds;
  dataset.publication = publication_of(preview.scenario);
  dataset.host = host_name();
  dataset.threads = workers.threads();
  const Result<FolderState> state = open_work(folder, dataset.identity, 1, false);
  if (!state) return state.error();
  if (Status made = make_preview_pings(preview, folder, workers); !made) return made;
  const auto finished = finish_dataset(folder, dataset);
  return finished ? Status() : Status(finished.error());
}

PreviewOf preview_of(const Preview& preview) {
  constexpr std::uint32_t kMostPoints = 1000;
  PreviewOf of;
  of.pings = preview.pings;
  of.all_pings = preview.session.ping_times_s.size();
  for (const std::uint32_t ping :
       spread_pings(static_cast<std::uint32_t>(of.all_pings), kMostPoints)) {
    of.path_m.push_back(sonar_pose(preview.session, ping).position_m);
  }
  return of;
}

Status write_page(const PreviewOptions& options, Preview& preview, const fs::path& page,
                  const Workers& workers) {
  if (Status go = unless_interrupted(); !go) return go;
  const Result<FolderName> folder = temporary_folder();
  if (!folder) return folder.error();
  if (Status made = make_data_set(preview, **folder, workers); !made) return made;
  ReportOptions report;
  report.dataset = **folder;
  report.output = page;
  report.max_pings = static_cast<int>(preview.pings.size());
  report.threads = options.threads;
  report.preview = true;
  report.preview_of = preview_of(preview);
  report.stop = interrupted;
  const Result<ReportSummary> written = write_report(report);
  return written ? Status() : Status(written.error());
}

// Whether the error can be corrected in the scenario or in a file that it names.
bool is_of_input(const Error& error) {
  return exit_code(error.kind) == exit_code(ErrorKind::usage) || error.kind == ErrorKind::io;
}

// Errors of the scenario alone, before its world is built; empty if there are none.
std::string scenario_faults(const PreviewOptions& options) {
  const Result<std::string> text = read_scenario_text(options.input.scenario);
  if (!text) return text.error().message;
  const Result<Scenario> scenario = scenario_of(options, *text, options.sequence);
  return scenario ? std::string() : scenario.error().message;
}

// The program may stop reading a scenario with errors before it knows all files. Then a missing
// file that appears can change the errors, although no known file changes. `told` has the previous
// errors.
void wait_for_work(const PreviewOptions& options, const std::string* told, FileWatch& files) {
  std::function<bool()> faults_changed;
  if (told != nullptr) {
    faults_changed = [&options, told] { return scenario_faults(options) != *told; };
  }
  wait_for_change(files, faults_changed, interrupted);
}

// `is_again` means that the path of the page has been printed already.
void tell_page(const PreviewOptions& options, const fs::path& page, double seconds, bool is_again) {
  if (options.quiet) return;
  tell("{} in {:.1f} s{}\n", is_again ? std::string("again") : page.string(), seconds,
       options.watch && !is_again ? "; watching until Ctrl-C" : "");
}

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Status preview_once(const PreviewOptions& options, const fs::path& page, const Workers& workers) {
  const Clock::time_point start = Clock::now();
  const auto preview = prepare(options, workers, nullptr);
  if (!preview) return preview.error();
  if (Status written = write_page(options, **preview, page, workers); !written) return written;
  tell_page(options, page, seconds_since(start), false);
  return {};
}

Status watch(const PreviewOptions& options, const fs::path& page, const Workers& workers) {
  FileWatch files;
  files.watch({options.input.scenario});
  for (bool is_again = false; !interrupted();) {
    const Clock::time_point start = Clock::now();
    const std::string faults = scenario_faults(options);
    bool is_faulty = false;
    {
      const auto preview = prepare(options, workers, &files);
      is_faulty = !preview;
      if (is_faulty && !is_of_input(preview.error())) return preview.error();
      if (is_faulty) tell("{}\n", preview.error().message);
      const Status written = is_faulty ? Status() : write_page(options, **preview, page, workers);
      if (!written) return written;
    }
    if (!is_faulty) tell_page(options, page, seconds_since(start), is_again);
    is_again = is_again || !is_faulty;
    wait_for_work(options, is_faulty ? &faults : nullptr, files);
  }
  return unless_interrupted();
}

}  // namespace

Status preview(const PreviewOptions& options) {
  const fs::path& scenario = options.input.scenario;
  fs::path page = options.output;
  if (page.empty()) page = scenario.stem().string() + "_preview.html";
  const Workers workers(options.threads);
  listen_for_interrupts();
  std::error_code error;
  if (!options.watch || !fs::exists(scenario, error)) return preview_once(options, page, workers);
  return watch(options, page, workers);
}

}  // namespace ensonify
