// The commands that show or convert existing results: their command line options, and the
// conversion to the options of each command.
//
//   parse_range  parse_numbers  parse_levels   A:B and MIN:MAX, for any command
//   add_report   run_report
//   add_preview  run_preview
//   add_figure   run_figure
//   add_compare  run_compare
//   add_fit  run_fit
//   add_export   run_export
//   add_render   run_render
//   add_import   run_import
//   add_presets
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "cli/commands.h"

namespace CLI {
class App;
}

namespace ensonify {

// Options of `figure` as given.
struct FigureWords {
  std::string pings, view, quantity, db, interpolation;
};

// Options of `render` as given.
struct RenderWords {
  std::string view, db, scale = "db", flip = "none", resampling = "bilinear";
  std::string sequences, range, decimation = "pick";
};

struct ViewArguments {
  ExportOptions exported;
  std::string format, view, labels;  // of `export`
  ReportOptions report;
  PreviewOptions preview;
  CompareOptions compare;
  FitOptions fit;
  FigureOptions figure;
  FigureWords figure_words;
  RenderOptions render;
  RenderWords render_words;
  ImportOptions imported;
  std::string imported_pings, imported_db;  // A:B, MIN:MAX
  bool quiet = false;
};

// Error (usage): not A:B in integers.
Result<std::pair<std::uint32_t, std::uint32_t>> parse_range(const char* option,
                                                            const std::string& text);

// Of A:B.
std::optional<std::pair<double, double>> parse_numbers(const std::string& text);

// Error (usage): not MIN:MAX in numbers, rising.
Result<std::array<double, 2>> parse_levels(const char* option, const std::string& text);

void add_report(CLI::App& app, ViewArguments& arguments);
// The caller adds the options that name the scenario.
CLI::App& add_preview(CLI::App& app, ViewArguments& arguments);
void add_figure(CLI::App& app, ViewArguments& arguments);
void add_compare(CLI::App& app, ViewArguments& arguments);
// After the scenario, which is the first argument.
void add_fit(CLI::App& command, ViewArguments& arguments);
void add_export(CLI::App& app, ViewArguments& arguments);
// In render_command.cpp.
void add_render(CLI::App& app, ViewArguments& arguments);
// In import_command.cpp.
void add_import(CLI::App& app, ViewArguments& arguments);
void add_presets(CLI::App& app, std::optional<std::string>& preset);

Status run_report(const ViewArguments& arguments);
Status run_preview(ScenarioOptions input, const ViewArguments& arguments);
Status run_figure(const ViewArguments& arguments);
Status run_compare(const ViewArguments& arguments);
Status run_fit(ScenarioOptions scenario, const ViewArguments& arguments);
Status run_export(const ViewArguments& arguments);
Status run_import(const ViewArguments& arguments);
Status run_render(const ViewArguments& arguments);

}  // namespace ensonify
