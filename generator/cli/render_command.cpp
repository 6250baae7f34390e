// `ensonify render`: its options, and how they become those of the renderer.
#include <CLI/CLI.hpp>
#include <utility>

#include "cli/command_line_views.h"
#include "cli/help_format.h"
#include "figure/drawing.h"

namespace ensonify {
namespace {

void add_gray_options(CLI::App& command, Display& display, RenderWords& words) {
  command.add_option(
      "--db", words.db,
      "MIN:MAX: levels of black and white; default: those of the data set's own images");
  command.add_flag("--auto", display.automatic_gain,
                   "automatic gain: the 99.5th percentile of each ping becomes white");
  command
      .add_option("--tvg", display.spreading,
                  "time-varied gain in dB per tenfold of range; default: 0")
      ->check(CLI::Range(0.0, 100.0));
  command.add_flag("--absorption", display.absorption,
                   "compensate the two-way absorption of the water");
  command.add_option("--gain-db", display.gain_db, "constant gain in dB; default: 0")
      ->check(CLI::Range(-1000.0, 1000.0));
  command
      .add_option(
          "--scale", words.scale,
          "db (default): gray level linear in dB; amplitude: linear in a power of the amplitude")
      ->check(CLI::IsMember({"db", "amplitude"}));
  command.add_option("--gamma", display.gamma, "power of the amplitude; default: 1")
      ->check(CLI::Range(0.05, 20.0));
  offer(*command.add_option("--color-map", display.color_map,
                            "color palette for the gray levels; default: none"),
        colour_maps());
}

void add_pixel_options(CLI::App& command, ShownPart& part, RenderWords& words) {
  command.add_option("--flip", words.flip, "horizontal (columns), vertical (rows) or both")
      ->check(CLI::IsMember({"none", "horizontal", "vertical", "both"}));
  command
      .add_option("--resampling", words.resampling,
                  "of Cartesian images; bilinear (default): mean intensity over each pixel; "
                  "nearest: the nearest polar pixel")
      ->check(CLI::IsMember({"bilinear", "nearest"}));
  command.add_option("--range", words.range,
                     "FROM:TO: show only these slant ranges, in meters; default: all");
  command
      .add_option("--every-sample", part.samples, "decimation: one row for K samples; default: 1")
      ->check(CLI::Range(1, 65'536));
  command
      .add_option("--every-beam", part.beams, "decimation: one column for K beams; default: 1")
      ->check(CLI::Range(1, 65'536));
  command
      .add_option("--decimation", words.decimation,
                  "pick (default): the middle one of K samples or beams; max: the loudest one")
      ->check(CLI::IsMember({"pick", "max"}));
}

Result<ShownPart> shown_part(ShownPart part, const RenderWords& words) {
  if (!words.range.empty()) {
    const auto range = parse_numbers(words.range);
    if (!range) {
      return Error{ErrorKind::usage,
                   "--range " + words.range + ": not a range; expected FROM:TO in m"};
    }
    part.range_m = {range->first, range->second};
  }
  if (words.decimation == decimation_name(Decimation::max)) part.decimation = Decimation::max;
  return part;
}

}  // namespace

void add_render(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command = *app.add_subcommand(
      "render", "make the 8-bit images of a data set again with other display settings");
  RenderOptions& options = arguments.render;
  RenderWords& words = arguments.render_words;
  command.add_option("DIR", options.dataset, "folder of a finished data set")->required();
  command
      .add_option("--name", options.name, "name of the render; the images go to DIR/renders/NAME")
      ->required();
  command.add_option("--view", words.view, "polar or cartesian; default: both")
      ->check(CLI::IsMember({"polar", "cartesian"}));
  add_gray_options(command, options.display, words);
  add_pixel_options(command, options.part, words);
  command
      .add_option("--jpeg-quality", options.jpeg_quality,
                  "write grayscale JPEG files of this quality; default: PNG files")
      ->check(CLI::Range(1, 100));
  command.add_option("--sequences", words.sequences, "A:B: only sequences A to B-1");
  command.add_option("--threads", options.threads, "threads; 0 uses all cores")
      ->check(CLI::Range(0, 4096));
  command.add_flag("--overwrite", options.overwrite, "overwrite an existing render of this name");
  command.add_flag("--quiet", arguments.quiet, "print no message at the end");
}

Status run_render(const ViewArguments& arguments) {
  RenderOptions options = arguments.render;
  const RenderWords& words = arguments.render_words;
  if (!words.view.empty()) {
    options.view = words.view == "polar" ? ImageView::polar : ImageView::cartesian;
  }
  if (!words.db.empty()) {
    const auto db = parse_levels("--db", words.db);
    if (!db) return db.error();
    options.limits_db = *db;
  }
  if (!words.sequences.empty()) {
    const auto sequences = parse_range("--sequences", words.sequences);
    if (!sequences) return sequences.error();
    options.sequences = *sequences;
  }
  const auto part = shown_part(options.part, words);
  if (!part) return part.error();
  options.part = *part;
  options.display.scale = words.scale == "db" ? GreyScale::db : GreyScale::amplitude;
  if (words.resampling == resampling_name(Resampling::nearest)) {
    options.display.resampling = Resampling::nearest;
  }
  for (const Flip flip : {Flip::horizontal, Flip::vertical, Flip::both}) {
    if (words.flip == flip_name(flip)) options.display.flip = flip;
  }
  return render_command(std::move(options), arguments.quiet);
}

}  // namespace ensonify
