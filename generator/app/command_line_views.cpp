#include "app/command_line_views.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "app/help_format.h"
#include "figure/drawing.h"

namespace ensonify {
namespace {

// A:B.
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
      fmt::format("{} {}: accepted is A:B, the first and the one after the last", option, text)};
}

void add_report(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command = *app.add_subcommand("report", "look at a data set: one page of HTML");
  ReportOptions& options = arguments.report;
  command.add_option("DIR", options.dataset, "a finished data set")->required();
  command.add_option("-o,--output", options.output, "the page; DIR_report.html by default");
  command
      .add_option("--pings", options.max_pings,
                  "of more pings, this many are shown, spread evenly; 200 by default")
      ->check(CLI::Range(1, 100'000));
  command.add_option("--threads", options.threads, "threads; 0: all that the machine has")
      ->check(CLI::Range(0, 4096));
  command.add_flag("--overwrite", options.overwrite,
                   "replace a file that is not a page of ensonify");
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
  FigureWords& words = arguments.figure_words;
  command.add_option("DIR", options.dataset, "a finished data set")->required();
  command.add_option("-o,--output", options.output, "FILE.png, .svg, .webp or .mp4 (needs ffmpeg)")
      ->required();
  command.add_option("--sequence", options.sequence, "the first by default");
  command.add_option("--ping", options.ping, "of .png and .svg; the first by default");
  command.add_option("--pings", words.pings,
                     "A:B: pings A to B-1, of .webp and .mp4; all by default");
  command.add_option("--fps", options.fps, "frames a second; as the pings were by default");
  command.add_option("--view", words.view, "cartesian (default) or polar")
      ->check(CLI::IsMember({"cartesian", "polar"}));
  command
      .add_option("--quantity", words.quantity,
                  "level (default), clean, elevation, instance, semantic, shadow or multipath")
      ->check(CLI::IsMember(
          {"level", "clean", "elevation", "instance", "semantic", "shadow", "multipath"}));
  command.add_option("--db", words.db, "MIN:MAX: limits of the colours; from the ping by default");
  offer(*command.add_option("--colour-map", options.colour_map, "colour map of the levels"),
        colour_maps());
  command.add_option("--interpolation", words.interpolation, "nearest (default) or bilinear")
      ->check(CLI::IsMember({"nearest", "bilinear"}));
  command.add_flag("--outlines", options.outlines, "outlines of instances, with their names");
  command.add_option("--instances", options.instances, "NAME,NAME: no others")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_option("--title", options.title, "in place of name and ping; \"\" for none");
  command.add_option("--width-px", options.width_px, "1200 by default, animated 800");
  command.add_flag("--overwrite", options.overwrite, "replace a file that is there");
  command.add_flag("--quiet", arguments.quiet, "no message at the end");
}

Status run_report(const ViewArguments& arguments) {
  return report_command(arguments.report, arguments.quiet);
}

Status run_preview(ScenarioOptions input, const ViewArguments& arguments) {
  PreviewOptions options = arguments.preview;
  options.input = std::move(input);
  options.quiet = arguments.quiet;
  if (options.watch && options.input.scenario == kStandardInput) {
    return Error{ErrorKind::usage, "--watch: standard input does not change, accepted is a file"};
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
    const auto db = parse_pair<double>(words.db);
    if (!db) return Error{ErrorKind::usage, "--db " + words.db + ": accepted is MIN:MAX in dB"};
    options.db = {db->first, db->second};
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

// Which objects the formats that list objects write.
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
           "these classes alone, separated by commas; else all of kind thing");
  add_list("--exclude", options.exclude, "all but these");
  command.add_option("--min-pixels", options.min_pixels, "least pixels of the mask (1)")
      ->check(CLI::Range(1, 1'000'000'000))
      ->group(kGroup);
  command
      .add_option("--min-visible", options.min_visible,
                  "least share of the amodal mask that is visible")
      ->check(CLI::Range(0.0, 1.0))
      ->group(kGroup);
}

void add_export(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command = *app.add_subcommand("export", "write a data set in another format");
  ExportOptions& options = arguments.exported;
  command.add_option("DIR", options.dataset, "a finished data set")->required();
  offer(*command.add_option("--format", arguments.format, "one of those below")->required(),
        export_formats());
  command.add_option("-o,--output", options.output, "what is written: must be new or empty")
      ->required();
  command.add_option("--view", arguments.view, "which image of a ping: polar or cartesian")
      ->check(CLI::IsMember({"polar", "cartesian"}));
  command.add_option("--labels", arguments.labels, "segments (outlines) or boxes")
      ->check(CLI::IsMember({"segments", "boxes"}));
  command.add_flag("--stack", options.stack, "all sequences in one array");
  command.add_flag("--pad", options.pad, "... of the size of the largest where they differ");
  command.add_option("--shard-size-mb", options.shard_size_mb, "most megabytes of a shard")
      ->check(CLI::Range(1, 1'000'000));
  command.add_option("--margin-px", options.margin_px, "pixels around the box of a crop (8)")
      ->check(CLI::Range(0, 65535));
  command.add_option("--split", options.split, "the sequences of this split alone")
      ->check(CLI::IsMember({"train", "val", "test"}));
  command.add_option("--render", options.render,
                     "name of a render: its 8-bit images in place of the data set's own");
  command.add_flag("--quiet", arguments.quiet, "no message at the end");
  add_object_options(command, options);
  command.footer(export_format_list());
}

void add_render(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command = *app.add_subcommand(
      "render", "make the 8-bit images of a data set again, with another display");
  RenderOptions& options = arguments.render;
  RenderWords& words = arguments.render_words;
  Display& display = options.display;
  command.add_option("DIR", options.dataset, "a finished data set")->required();
  command.add_option("--name", options.name, "of the render: the images go to DIR/renders/NAME")
      ->required();
  command.add_option("--view", words.view, "polar or cartesian; both by default")
      ->check(CLI::IsMember({"polar", "cartesian"}));
  command.add_option("--db", words.db,
                     "MIN:MAX: black and white; by default those of the data set's own images");
  command.add_flag("--auto", display.automatic_gain,
                   "automatic gain: the 99.5th percentile of each ping becomes white");
  command
      .add_option("--tvg", display.spreading,
                  "time-varied gain, dB for each tenfold of range; 0 by default")
      ->check(CLI::Range(0.0, 100.0));
  command.add_flag("--absorption", display.absorption,
                   "compensate the two-way absorption of the water");
  command.add_option("--gain-db", display.gain_db, "constant gain; 0 by default")
      ->check(CLI::Range(-1000.0, 1000.0));
  command
      .add_option("--scale", words.scale,
                  "db (default): gray is linear in dB; amplitude: in a power of the amplitude")
      ->check(CLI::IsMember({"db", "amplitude"}));
  command.add_option("--gamma", display.gamma, "that power; 1 by default")
      ->check(CLI::Range(0.05, 20.0));
  offer(*command.add_option("--colour-map", display.color_map,
                            "colours of the gray levels, as a palette; none by default"),
        colour_maps());
  command.add_option("--flip", words.flip, "horizontal (columns), vertical (rows) or both")
      ->check(CLI::IsMember({"none", "horizontal", "vertical", "both"}));
  command
      .add_option("--resampling", words.resampling,
                  "of Cartesian images; bilinear (default): between beams and samples, the mean "
                  "where these are denser than pixels; nearest: the nearest polar pixel")
      ->check(CLI::IsMember({"bilinear", "nearest"}));
  command.add_option("--sequences", words.sequences, "A:B: only sequences A to B-1");
  command.add_option("--threads", options.threads, "threads; 0: all that the machine has")
      ->check(CLI::Range(0, 4096));
  command.add_flag("--overwrite", options.overwrite, "replace a render of this name");
  command.add_flag("--quiet", arguments.quiet, "no message at the end");
}

Status run_render(const ViewArguments& arguments) {
  RenderOptions options = arguments.render;
  const RenderWords& words = arguments.render_words;
  if (!words.view.empty()) {
    options.view = words.view == "polar" ? ImageView::polar : ImageView::cartesian;
  }
  if (!words.db.empty()) {
    const auto db = parse_pair<double>(words.db);
    if (!db) return Error{ErrorKind::usage, "--db " + words.db + ": accepted is MIN:MAX in dB"};
    options.limits_db = {db->first, db->second};
  }
  if (!words.sequences.empty()) {
    const auto sequences = parse_range("--sequences", words.sequences);
    if (!sequences) return sequences.error();
    options.sequences = *sequences;
  }
  options.display.scale = words.scale == "db" ? GreyScale::db : GreyScale::amplitude;
  if (words.resampling == resampling_name(Resampling::nearest)) {
    options.display.resampling = Resampling::nearest;
  }
  for (const Flip flip : {Flip::horizontal, Flip::vertical, Flip::both}) {
    if (words.flip == flip_name(flip)) options.display.flip = flip;
  }
  return render_command(std::move(options), arguments.quiet);
}

void add_presets(CLI::App& app, std::optional<std::string>& preset) {
  CLI::App& command =
      *app.add_subcommand("presets", "sonar presets with their numbers and sources");
  offer(*command.add_option("NAME", preset, "print this one"), sonar_presets());
}

}  // namespace ensonify
