// The commands that show what was made: their options, and from those to a command's own.
//
//   add_report   run_report
//   add_preview  run_preview
//   add_figure   run_figure
#pragma once

#include <string>

#include "app/commands.h"

namespace CLI {
class App;
}

namespace ensonify {

// Options of figures as they are written.
struct FigureWords {
  std::string pings, view, channel, db, interpolation;
};

struct ViewArguments {
  ReportOptions report;
  PreviewOptions preview;
  FigureOptions figure;
  FigureWords figure_words;
  bool quiet = false;
};

void add_report(CLI::App& app, ViewArguments& arguments);
// The caller adds what names the scenario.
CLI::App& add_preview(CLI::App& app, ViewArguments& arguments);
void add_figure(CLI::App& app, ViewArguments& arguments);

Status run_report(const ViewArguments& arguments);
Status run_preview(ScenarioOptions input, const ViewArguments& arguments);
Status run_figure(const ViewArguments& arguments);

}  // namespace ensonify
