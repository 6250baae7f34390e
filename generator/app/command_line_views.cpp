#include "app/command_line_views.h"

#include <CLI/CLI.hpp>

namespace ensonify {

void add_report(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command = *app.add_subcommand("report", "look at a data set: one page of HTML");
  ReportOptions& options = arguments.report;
  command.add_option("DIR", options.dataset, "a finished data set")->required();
  command.add_option("-o,--output", options.output, "the page; DIR_report.html by default");
  command.add_flag("--quiet", arguments.quiet, "no message at the end");
}

CLI::App& add_preview(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command =
      *app.add_subcommand("preview", "look at a scenario: a few pings at reduced cost, as a page");
  PreviewOptions& options = arguments.preview;
  command.add_option("-o,--output", options.output, "the page; NAME_preview.html by default");
  command.add_option("--pings", options.pings, "so many, spread over the run; 3 by default")
      ->check(CLI::Range(1, 200));
  command.add_option("--sequence", options.sequence, "which one; 0 by default");
  command.add_option("--threads", options.threads, "threads; 0: all")->check(CLI::Range(0, 4096));
  command.add_flag("--full", options.full, "with all rays, as generate traces them");
  command.add_flag("--watch", options.watch,
                   "again whenever the scenario or a file that it names changes, until Ctrl-C");
  command.add_flag("--quiet", arguments.quiet, "no messages but faults and warnings");
  return command;
}

void add_figure(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command = *app.add_subcommand("figure", "draw a ping with axes and a colour bar");
  FigureOptions& options = arguments.figure;
  command.add_option("DIR", options.dataset, "a finished data set")->required();
  command.add_option("-o,--output", options.output, "the figure")->required();
  command.add_flag("--quiet", arguments.quiet, "no message at the end");
}

Status run_report(const ViewArguments& arguments) {
  return report_command(arguments.report, arguments.quiet);
}

Status run_preview(ScenarioOptions input, const ViewArguments& arguments) {
  PreviewOptions options = arguments.preview;
  options.input = std::move(input);
  options.quiet = arguments.quiet;
  return preview(options);
}

Status run_figure(const ViewArguments& arguments) {
  return figure_command(arguments.figure, arguments.quiet);
}

}  // namespace ensonify
