#include <fmt/format.h>

#include <cstdio>

#include "cli/commands.h"
#include "compare/comparison_text.h"
#include "core/counted.h"
#include "dataset/rig_file.h"
#include "dataset/verify.h"
#include "render/shown_images.h"
#include "run/make_dataset.h"
#include "run/program.h"
#include "run/terminal.h"
#include "scenario/text.h"
#include "sweep/folder.h"

namespace ensonify {

// A word that no sonar has as its name.
static constexpr std::string_view kMaterialPresets = "materials";

Status presets(const std::optional<std::string>& name) {
  if (name == kMaterialPresets) {
    answer("{}", materials_yaml());
    return {};
  }
  std::vector<std::string_view> names = {kMaterialPresets};
  for (const SonarPreset& preset : sonar_presets()) {
    if (name && preset.name == *name) {
      answer("{}", preset.yaml);
      return {};
    }
    names.emplace_back(preset.name);
  }
  if (name) {
    return Error{ErrorKind::usage, fmt::format("no preset {}{}; expected one of {}", shown(*name),
                                               hint(*name, names), joined(names))};
  }
  answer("{:<20} {:>9} {:>9} {:>9} {:>6} {:>7} {:>7}\n", "preset", "f kHz", "b kHz", "fov deg",
         "beams", "width", "range m");
  for (const SonarPreset& preset : sonar_presets()) {
    const auto scenario =
        parse_scenario(fmt::format("ensonify: 1\nname: {0}\nsonar: {{preset: {0}}}\n", preset.name),
                       "preset " + preset.name, ".");
    if (!scenario) return scenario.error();
    const SonarSpec& s = scenario->sonar;
    answer("{:<20} {:>9g} {:>9g} {:>9} {:>6} {:>7g} {:>7g}\n", preset.name, s.frequency_hz / 1e3,
           s.bandwidth_hz / 1e3, fmt::format("{:g}x{:g}", s.beam_fov_deg, s.elevation_width_deg),
           s.beam_count, s.beam_width_deg, s.range_max_m);
  }
  answer(
      "\nensonify presets NAME prints one with its sources, ensonify presets materials the "
      "materials. b is the bandwidth at the longest "
      "range; presets\nwith rows under by_range_max_m have a larger one at shorter ranges.\n");
  return {};
}

namespace {

// Checks the planned runs one after another; a run that is not done is an error, too.
Result<VerifyReport> verify_sweep(const std::filesystem::path& folder, const Workers& workers) {
  const Result<std::optional<Plan>> plan = read_plan(folder);
  if (!plan) return plan.error();
  VerifyReport all;
  if (!*plan) all.faults.push_back(fmt::format("{}: is missing", kPlanFile));
  for (const PlannedRun& run : plan->value_or(Plan{})) {
    const std::string name = run_folder(run.id);
    if (!run_is_done(folder, run.id)) {
      all.faults.push_back(fmt::format("{}: is not done ({})", name, run.name));
      continue;
    }
    const Result<VerifyReport> report = verify_dataset(folder / name, workers);
    if (!report) {
      all.faults.push_back(fmt::format("{}: {}", name, report.error().message));
      continue;
    }
    for (const std::string& fault : report->faults) all.faults.push_back(name + "/" + fault);
    all.files += report->files;
    all.bytes += report->bytes;
  }
  return all;
}

// Checks the data sets of all instruments one after another.
VerifyReport verify_rig(const std::filesystem::path& folder, const RigFile& rig,
                        const Workers& workers) {
  VerifyReport all;
  all.files = 1;  // rig.json
  for (const RigInstrument& instrument : rig.instruments) {
    const Result<VerifyReport> report = verify_dataset(folder / instrument.name, workers);
    if (!report) {
      all.faults.push_back(fmt::format("{}: {}", instrument.name, report.error().message));
      continue;
    }
    for (const std::string& fault : report->faults) {
      all.faults.push_back(instrument.name + "/" + fault);
    }
    for (const SequenceFailure& failure : report->failed) {
      all.failed.push_back({failure.sequence, instrument.name + ": " + failure.error});
    }
    all.files += report->files;
    all.bytes += report->bytes;
    all.sequences += report->sequences;
  }
  return all;
}

Result<VerifyReport> verify_folder(const std::filesystem::path& folder, const Workers& workers) {
  const Result<std::optional<SweepHead>> sweep = read_sweep_head(folder);
  if (!sweep) return sweep.error();
  if (*sweep) return verify_sweep(folder, workers);
  const Result<std::optional<RigFile>> rig = read_rig(folder);
  if (!rig) return rig.error();
  if (*rig) return verify_rig(folder, **rig, workers);
  return verify_dataset(folder, workers);
}

}  // namespace

Status verify(const std::filesystem::path& folder, int threads) {
  const Workers workers(threads);
  const Result<VerifyReport> report = verify_folder(folder, workers);
  if (!report) return report.error();
  if (report->faults.empty()) {
    tell("{}: complete and undamaged: {}, {} bytes\n", folder.string(),
         counted(report->files, "file"), report->bytes);
    // These are not damage: the data set contains everything that can be made.
    if (!report->failed.empty()) {
      tell("{}: {}\n", folder.string(),
           failures_text(report->failed, report->sequences + report->failed.size()));
    }
    return {};
  }
  std::string text;
  for (const std::string& fault : report->faults) text += fault + "\n";
  return Error{ErrorKind::damage, fmt::format("{}{}: {}", text, folder.string(),
                                              counted(report->faults.size(), "error"))};
}

Status export_command(const std::string& format_name, ExportOptions options, bool quiet) {
  const ExportFormat* format = find_export_format(format_name);
  if (format == nullptr) {
    std::vector<std::string_view> names;
    for (const ExportFormat& known : export_formats()) names.emplace_back(known.name);
    return Error{ErrorKind::usage,
                 fmt::format("--format {}: unknown format{}; expected {}", one_line(format_name),
                             hint(format_name, names), joined(names))};
  }
  listen_for_interrupts();
  options.stop = interrupted;
  const auto report = export_dataset(*format, options);
  if (!report) return report.error();
  if (report->left_out > 0) {
    tell("warning: {} of the sweep {} not done and left out; {} of the output lists them\n",
         counted(report->left_out, "run"), report->left_out == 1 ? "is" : "are", kRunsFile);
  }
  if (quiet) return {};
  const std::string runs = report->runs > 0 ? " of " + counted(report->runs, "run") : "";
  tell("{}: {} of {}{} as {}\n", options.output.string(), counted(report->pings, "ping"),
       counted(report->sequences, "sequence"), runs, format->name);
  return {};
}

std::string export_format_list() {
  std::string text = "formats (docs/export.md):\n";
  for (const ExportFormat& format : export_formats()) {
    std::string takes = format.options;
    if (format.has(kListsObjects)) takes += " and the options for objects";
    text += fmt::format("  {:<13} {}{}{}\n", format.name, format.what,
                        takes.empty() ? "" : "; takes ", takes);
  }
  return text;
}

Status report_command(const ReportOptions& given, bool quiet) {
  listen_for_interrupts();
  ReportOptions options = given;
  options.stop = interrupted;
  const Result<ReportSummary> summary = write_report(options);
  if (!summary) return summary.error();
  if (quiet) return {};
  const double megabytes = static_cast<double>(summary->bytes) / 1e6;
  if (summary->runs > 0) {
    tell("{}: {}, {} with an image, {:.1f} MB\n", summary->output.string(),
         counted(summary->runs, "run"), summary->shown, megabytes);
  } else {
    tell("{}: {} of {}, {:.1f} MB\n", summary->output.string(), summary->shown,
         counted(summary->pings, "ping"), megabytes);
  }
  return {};
}

Status compare_command(CompareOptions options, bool quiet) {
  listen_for_interrupts();
  options.stop = interrupted;
  const Result<Comparison> comparison = compare_folders(options);
  if (!comparison) return comparison.error();
  if (!quiet) answer("{}", comparison_table(*comparison));
  if (!quiet && !options.page.empty()) tell("{}: written\n", options.page.string());
  return {};
}

Status figure_command(FigureOptions options, bool quiet) {
  if (options.title &&
      (first_invalid_utf8(*options.title) || first_control_character(*options.title, ""))) {
    return Error{ErrorKind::usage, "--title: the text is invalid; expected one line of UTF-8 text"};
  }
  listen_for_interrupts();
  options.stop = interrupted;
  const auto report = write_figure(options);
  if (!report) return report.error();
  if (quiet) return {};
  std::string limits;
  if (report->limits) {
    const bool angle = options.quantity == FigureQuantity::elevation;
    limits = fmt::format(", {:g} to {:g} {}", (*report->limits)[0], (*report->limits)[1],
                         angle ? "degrees" : "dB");
  }
  tell("{}: {} {}{}\n", options.output.string(), report->frames,
       report->frames == 1 ? "ping" : "pings", limits);
  return {};
}

Status render_command(RenderOptions options, bool quiet) {
  listen_for_interrupts();
  options.stop = interrupted;
  options.program_version = program_version();
  options.program_commit = program_commit();
  const auto report = render_dataset(options);
  if (!report) return report.error();
  const std::string warning =
      display_warning(report->display, report->counts, options.dataset.string());
  if (!warning.empty()) tell("warning: {}\n", warning);
  if (quiet) return {};
  tell("{}: {} of {}, {:g} to {:g} dB\n", report->folder.string(), counted(report->pings, "ping"),
       counted(report->sequences, "sequence"), report->display.limits_db[0],
       report->display.limits_db[1]);
  return {};
}

}  // namespace ensonify
