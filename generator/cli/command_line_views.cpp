#include "cli/command_line_views.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "cli/help_format.h"
#include "figure/drawing.h"

namespace ensonify {
namespace {

// Parses A:B.
template <class Number>
std::optional<std::pair<Number, Number>> parse_pair(const std::string& text) {
  std::pair<Number, Number> pair;
  const char* end = text.data() + text.size();
  const auto a = std::from_chars(text.data(), end, pair.first);
  if (a.ec != std::errc() || a.ptr == end || *a.ptr != ':') return std::nullopt;
  const auto b = std::from_chars(a.ptr + 1, end, pair.second);
  return b.ec == std::errc() && b.ptr == end ? std::optional(pair) : std::nullopt;
}

}  // namespace

Result<std::pair<std::uint32_t, std::uint32_t>> parse_range(const char* option,
                                                            const std::string& text) {
  if (const auto range = parse_pair<std::uint32_t>(text)) return *range;
  return Error{
      ErrorKind::usage,
      fmt::format("{} {}: not a range; expected A:B, the first number and the one after the last",
                  option, text)};
}

std::optional<std::pair<double, double>> parse_numbers(const std::string& text) {
  return parse_pair<double>(text);
}

Result<std::array<double, 2>> parse_levels(const char* option, const std::string& text) {
  const auto db = parse_pair<double>(text);
  constexpr double kMostDb = 1000;
  if (db && db->first < db->second && db->first >= -kMostDb && db->second <= kMostDb) {
    return std::array{db->first, db->second};
  }
  return Error{
      ErrorKind::usage,
      fmt::format("{} {}: not a range of levels; expected MIN:MAX in dB, between -1000 and "
                  "1000",
                  option, text)};
}

void add_report(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command =
      *app.add_subcommand("report", "write an HTML page that shows a data set, a sweep or a rig");
  ReportOptions& options = arguments.report;
  command.add_option("DIR", options.dataset, "folder of a finished data set, or of a sweep")
      ->required();
  command.add_option("-o,--output", options.output, "HTML file; default: DIR_report.html");
  command
      .add_option("--pings", options.max_pings,
                  "largest number of pings to show, evenly spaced; default: 200")
      ->check(CLI::Range(1, 100'000));
  command.add_option("--threads", options.threads, "threads; 0 uses all cores")
      ->check(CLI::Range(0, 4096));
  command.add_flag("--overwrite", options.overwrite,
                   "overwrite a file that is not a page of ensonify");
  command.add_flag("--quiet", arguments.quiet, "print no message at the end");
}

CLI::App& add_preview(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command = *app.add_subcommand(
      "preview", "write an HTML page with a few pings of a scenario at reduced cost");
  PreviewOptions& options = arguments.preview;
  command.add_option("-o,--output", options.output, "HTML file; default: NAME_preview.html");
  command.add_option("--pings", options.pings, "number of pings, spread over the run; default: 3")
      ->check(CLI::Range(1, 200));
  command.add_option("--sequence", options.sequence, "sequence to show; default: 0");
  command.add_option("--threads", options.threads, "threads; 0 uses all cores")
      ->check(CLI::Range(0, 4096));
  command.add_flag("--full", options.full, "trace all rays, as generate does");
  command.add_flag("--watch", options.watch,
                   "repeat whenever the scenario or a file that it names changes, until Ctrl-C");
  command.add_flag("--quiet", arguments.quiet, "print only errors and warnings");
  return command;
}

void add_compare(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command =
      *app.add_subcommand("compare", "measure how a simulated data set differs from a real one");
  CompareOptions& options = arguments.compare;
  command
      .add_option("REAL", options.real, "folder of a finished data set, or of crops (PNG, JPEG)")
      ->required();
  command.add_option("SIMULATED", options.simulated, "another one of the same kind")->required();
  command
      .add_option("--pings", options.amount.images,
                  "largest number of pings or crops of each that are measured; default: 200")
      ->check(CLI::Range(2, 100'000));
  command
      .add_option("--blocks", options.amount.blocks,
                  "blocks of consecutive pings, for the errors; default: 10, or one for each of 10 "
                  "to 40 sequences")
      ->check(CLI::Range(2, 1000));
  command.add_option("--mask-real", options.mask_real,
                     "8-bit PNG [samples, beams] of the real data; pixels with 0 are not measured");
  command.add_option("--mask-simulated", options.mask_simulated, "the same of the simulated data");
  command.add_option("--classes-real", options.classes_real,
                     "folder of an 8-bit PNG [samples, beams] for each ping of the real data: 0 "
                     "background, 255 shadow, else objects; each is compared apart");
  command.add_option("--classes-simulated", options.classes_simulated,
                     "the same of the simulated data; default: its labels");
  command
      .add_option("--objects", options.objects,
                  "of labels: names of the classes that are objects, separated by commas; default: "
                  "things of finite size")
      ->delimiter(',');
  command.add_option("--bottom-real", options.bottom_real_m,
                     "height z of a flat bottom in meters, in the frame of the poses of the real "
                     "data; with --bottom-simulated, levels are compared by grazing angle");
  command.add_option("--bottom-simulated", options.bottom_simulated_m,
                     "the same of the simulated data");
  command
      .add_option("--gamma", options.gamma,
                  "of crops: gray level = amplitude to this power; default: 1")
      ->check(CLI::Range(0.05, 20.0));
  command
      .add_option(
          "--comb", options.comb_period,
          "beams from one to the next that fires with it, for the comb; default: 8, or that "
          "of an ARIS with 48, 64 or 96 beams")
      ->check(CLI::Range(2, 64));
  command.add_option("--json", options.json, "also write all numbers to this file");
  command.add_option("--report", options.page, "also write an HTML page with curves and images");
  command.add_option("--seed", options.seed, "seed of the permutations of blocks; default: 0");
  command.add_option("--threads", options.threads, "threads; 0 uses all cores")
      ->check(CLI::Range(0, 4096));
  command.add_flag("--overwrite", options.overwrite,
                   "overwrite a file that ensonify compare did not write");
  command.add_flag("--quiet", arguments.quiet, "print no table");
}

void add_fit(CLI::App& command, ViewArguments& arguments) {
  FitOptions& options = arguments.fit;
  command.add_option("REAL", options.recording, "folder of a data set, such as an imported log")
      ->required();
  command
      .add_option("-o,--output", options.output, "folder of the fit; one that exists is resumed")
      ->required();
  command
      .add_option(
          "--key", options.keys,
          "PATH=LOW:HIGH: a number of the scenario and its range; PATH=LOW:HIGH:log searches "
          "its logarithm; repeat for several keys")
      ->required();
  command
      .add_option("--pings", options.amount.images,
                  "largest number of pings of recording and simulation; default: 200")
      ->check(CLI::Range(6, 100'000));
  command
      .add_option("--blocks", options.amount.blocks,
                  "blocks of consecutive pings, for the errors; default: 10, or one for each of 10 "
                  "to 40 sequences")
      ->check(CLI::Range(3, 1000));
  command.add_option("--mask-real", options.mask,
                     "8-bit PNG [samples, beams] of the recording; pixels with 0 are not measured");
  command
      .add_option(
          "--max-simulations", options.max_simulations,
          "number of simulations after which the search takes no further step; default: 400")
      ->check(CLI::Range(10, 100'000));
  command.add_option("--threads", options.threads, "threads; 0 uses all cores")
      ->check(CLI::Range(0, 4096));
  command.add_flag("--overwrite", options.overwrite, "forget earlier simulations in the folder");
  command.add_flag("--quiet", options.quiet, "print only errors and warnings");
}

void add_figure(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command = *app.add_subcommand("figure", "draw a ping with axes and a color bar");
  FigureOptions& options = arguments.figure;
  FigureWords& words = arguments.figure_words;
  command.add_option("DIR", options.dataset, "folder of a finished data set")->required();
  command.add_option("-o,--output", options.output, "FILE.png, .svg, .webp or .mp4 (needs ffmpeg)")
      ->required();
  command.add_option("--sequence", options.sequence, "sequence to draw; default: the first");
  command.add_option("--ping", options.ping, "ping to draw as .png or .svg; default: the first");
  command.add_option("--pings", words.pings, "A:B: pings A to B-1 for .webp or .mp4; default: all");
  command.add_option("--fps", options.fps, "frames per second; default: the ping rate");
  command.add_option("--view", words.view, "cartesian (default) or polar")
      ->check(CLI::IsMember({"cartesian", "polar"}));
  command
      .add_option("--quantity", words.quantity,
                  "level (default), clean (the expected level), elevation, instance, semantic, "
                  "shadow or multipath")
      ->check(CLI::IsMember(
          {"level", "clean", "elevation", "instance", "semantic", "shadow", "multipath"}));
  command.add_option("--db", words.db, "MIN:MAX: color limits in dB; default: from the ping");
  offer(*command.add_option("--color-map", options.colour_map, "color map of the levels"),
        colour_maps());
  command.add_option("--interpolation", words.interpolation, "nearest (default) or bilinear")
      ->check(CLI::IsMember({"nearest", "bilinear"}));
  command.add_flag("--outlines", options.outlines,
                   "draw the outlines of instances with their names");
  command
      .add_option("--instances", options.instances,
                  "NAME,NAME: draw only these instances (outlines or masks)")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_option("--title", options.title, "title; default: name and ping, \"\" for none");
  command.add_option("--width-px", options.width_px,
                     "width of the image; default: 1200, or 800 for an animation");
  command.add_flag("--overwrite", options.overwrite, "overwrite an existing file");
  command.add_flag("--quiet", arguments.quiet, "print no message at the end");
}

Status run_report(const ViewArguments& arguments) {
  return report_command(arguments.report, arguments.quiet);
}

Status run_preview(ScenarioOptions input, const ViewArguments& arguments) {
  PreviewOptions options = arguments.preview;
  options.input = std::move(input);
  options.quiet = arguments.quiet;
  if (options.watch && options.input.scenario == kStandardInput) {
    return Error{ErrorKind::usage,
                 "--watch: standard input does not change; expected a scenario file"};
  }
  return preview(options);
}

Status run_figure(const ViewArguments& arguments) {
  FigureOptions options = arguments.figure;
  const FigureWords& words = arguments.figure_words;
  if (!words.pings.empty()) {
    const auto pings = parse_range("--pings", words.pings);
    if (!pings) return pings.error();
    options.pings = *pings;
  }
  if (!words.db.empty()) {
    const auto db = parse_levels("--db", words.db);
    if (!db) return db.error();
    options.db = *db;
  }
  constexpr std::pair<std::string_view, FigureQuantity> kQuantities[] = {
      {"level", FigureQuantity::level},         {"clean", FigureQuantity::clean},
      {"elevation", FigureQuantity::elevation}, {"instance", FigureQuantity::instance},
      {"semantic", FigureQuantity::semantic},   {"shadow", FigureQuantity::shadow},
      {"multipath", FigureQuantity::multipath}};
  for (const auto& [name, quantity] : kQuantities) {
    if (words.quantity == name) options.quantity = quantity;
  }
  options.view = words.view == "polar" ? FigureView::polar : FigureView::cartesian;
  options.bilinear = words.interpolation == "bilinear";
  return figure_command(options, arguments.quiet);
}

Status run_fit(ScenarioOptions scenario, const ViewArguments& arguments) {
  FitOptions options = arguments.fit;
  options.scenario = std::move(scenario);
  return fit_command(std::move(options));
}

Status run_compare(const ViewArguments& arguments) {
  return compare_command(arguments.compare, arguments.quiet);
}

Status run_export(const ViewArguments& arguments) {
  ExportOptions options = arguments.exported;
  if (!arguments.view.empty()) {
    options.view = arguments.view == "polar" ? PictureView::polar : PictureView::cartesian;
  }
  if (!arguments.labels.empty()) {
    options.labels = arguments.labels == "boxes" ? YoloLabels::boxes : YoloLabels::segments;
  }
  return export_command(arguments.format, std::move(options), arguments.quiet);
}

// Options of the formats that list objects.
static void add_object_options(CLI::App& command, ExportOptions& options) {
  constexpr const char* kGroup = "Objects";
  const auto add_list = [&](const char* name, auto& names, const char* what) {
    command.add_option(name, names, what)
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("A,B")
        ->group(kGroup);
  };
  add_list("--classes", options.classes,
           "only these classes, separated by commas; default: all of kind thing");
  add_list("--exclude", options.exclude, "leave out these classes, separated by commas");
  command
      .add_option("--min-pixels", options.min_pixels,
                  "minimum number of pixels of the mask; default: 1")
      ->check(CLI::Range(1, 1'000'000'000))
      ->group(kGroup);
  command
      .add_option("--min-visible", options.min_visible,
                  "minimum visible fraction of the amodal mask")
      ->check(CLI::Range(0.0, 1.0))
      ->group(kGroup);
}

void add_export(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command =
      *app.add_subcommand("export", "convert a data set or the runs of a sweep to another format");
  ExportOptions& options = arguments.exported;
  command.add_option("DIR", options.dataset, "folder of a finished data set, or of a sweep")
      ->required();
  offer(*command.add_option("--format", arguments.format, "one of the formats below")->required(),
        export_formats());
  command.add_option("-o,--output", options.output, "output path, new or empty")->required();
  command.add_option("--view", arguments.view, "image of a ping: polar or cartesian")
      ->check(CLI::IsMember({"polar", "cartesian"}));
  command.add_option("--labels", arguments.labels, "segments (outlines) or boxes")
      ->check(CLI::IsMember({"segments", "boxes"}));
  command.add_flag("--stack", options.stack, "stack all sequences in one array");
  command.add_flag("--pad", options.pad,
                   "with --stack, pad all sequences to the size of the largest");
  command.add_flag("--one-file", options.one_file,
                   "write all sequences to one file, with later times for later sequences");
  command
      .add_option("--shard-size-mb", options.shard_size_mb, "maximum size of a shard in megabytes")
      ->check(CLI::Range(1, 1'000'000));
  command
      .add_option("--margin-px", options.margin_px, "pixels around the box of a crop; default: 8")
      ->check(CLI::Range(0, 65535));
  command.add_option("--full-scale-db", options.full_scale_db,
                     "level of the largest count of a log whose counts are not recorded, or of "
                     "amplitude 1");
  command.add_option("--split", options.split, "only the sequences of this split")
      ->check(CLI::IsMember({"train", "val", "test"}));
  command.add_option("--render", options.render,
                     "use the 8-bit images of the render with this name");
  command.add_flag("--quiet", arguments.quiet, "print no message at the end");
  add_object_options(command, options);
  command.footer(export_format_list());
}

void add_presets(CLI::App& app, std::optional<std::string>& preset) {
  CLI::App& command = *app.add_subcommand(
      "presets", "list the sonar presets, or print one, or the materials, with their sources");
  offer(*command.add_option("NAME", preset, "preset to print, or materials"), sonar_presets());
}

}  // namespace ensonify
