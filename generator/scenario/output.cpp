// The keys of `output`, which select the files.
#include <algorithm>

#include <fmt/format.h>

#include "scenario/sections.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr int kMaxImageHeight = 16384;
constexpr NumberRange kSpreading = from_to(0, 100);
constexpr NumberRange kGreyDb = from_to(-1000, 1000);
constexpr NumberRange kElevationStep = from_to(0.01, 90);
constexpr NumberRange kWithinDb = from_to(0, 200);
constexpr int kMostLags = 64;
constexpr NumberRange kGamma = from_to(0.05, 20);

struct SeriesFormats {
  bool npy = true, exr = false;
  friend bool operator==(const SeriesFormats&, const SeriesFormats&) = default;
};

void timeseries_field(Fields& f, OutputSelection& selection) {
  SeriesFormats formats{selection.timeseries, selection.timeseries_exr};
  f.choice<SeriesFormats>({"timeseries", "Time series",
                           "File format of the beamformed complex baseband (IQ) of all beams"},
                          formats,
                          {{"npy", {true, false}},
                           {"exr", {false, true}},
                           {"both", {true, true}},
                           {"none", {false, false}}});
  selection.timeseries = formats.npy;
  selection.timeseries_exr = formats.exr;
}

// The word `true` stands for the gain that levels echoes of single targets, 40 log10 r + 2 alpha r.
void tvg_fields(Fields& f, Display& grey) {
  bool on = f.writing();
  const bool has_options =
      f.begin_switch({"tvg", "Time-varied gain", "Gain that increases with range"}, on);
  if (!f.writing() && on) {
    grey.spreading = 40;
    grey.absorption = true;
  }
  if (!has_options) return;
  f.number({"spreading", "Spreading",
            "Gain for each tenfold of range: 40 levels the echoes of targets, 30 those of a seabed "
            "at grazing angles, 20 those of a volume",
            "dB per tenfold of range"},
           grey.spreading, kSpreading);
  f.boolean({"absorption", "Absorption",
             "Whether the gain compensates the two-way absorption of the water"},
            grey.absorption);
  f.end();
}

void png_fields(Fields& f, OutputSpec& output) {
  if (!f.begin_switch(
          {"png", "8-bit display images", "PNG files; a map of options switches them on"},
          output.selection.png)) {
    return;
  }
  const bool plain = !output.png_db && output.png == Display{};
  if (!f.writing() || !plain) {
    f.choice<GreyScale>({"scale", "Scale",
                         "db: the gray level is linear in dB from black to white; amplitude: it is "
                         "proportional to the amplitude, and 0 is black"},
                        output.png.scale,
                        {{"db", GreyScale::db}, {"amplitude", GreyScale::amplitude}});
    f.number({"gamma", "Gamma",
              "Power of the amplitude to which the gray level is proportional; needs scale "
              "amplitude"},
             output.png.gamma, kGamma);
    if (output.png.gamma != 1 && output.png.scale == GreyScale::db) {
      f.fault(
          "gamma",
          "has no effect on a gray level that is linear in dB; expected only with scale amplitude");
    }
    const bool limited = f.numbers({"db", "Limits",
                                    "[black, white], black below white, of levels with gain; left "
                                    "out: from the expected levels of the first ping of up to two "
                                    "sequences, with time-varied gain, the same for all sequences",
                                    "dB re 1 µPa"},
                                   output.png_db, kGreyDb);
    if (limited && (*output.png_db)[0] >= (*output.png_db)[1]) {
      f.fault("db", fmt::format("the first level, {} dB, is not below the second, {} dB; expected "
                                "[black, white] with black below white",
                                (*output.png_db)[0], (*output.png_db)[1]));
    }
    tvg_fields(f, output.png);
    f.number({"gain_db", "Gain", "Constant gain"}, output.png.gain_db, kGreyDb);
    f.boolean({"automatic_gain", "Automatic gain",
               "Whether each ping gets a gain that puts the 99.5th percentile of its levels on the "
               "upper limit"},
              output.png.automatic_gain);
    f.choice<Resampling>(
        {"resampling", "Resampling",
         "How Cartesian images are made: bilinear: the mean intensity over each pixel's footprint, "
         "interpolated between beams and samples; nearest: the nearest polar pixel"},
        output.png.resampling,
        {{"bilinear", Resampling::bilinear}, {"nearest", Resampling::nearest}});
  }
  f.end();
}

// Labels that accompany images are on by default if there are polar or Cartesian images.
void hidden_label_fields(Fields& f, OutputSelection& selection) {
  const bool with_labels = selection.polar || selection.cartesian;
  const auto label = [&](const KeyText& text, bool possible, const char* pictures, bool& wanted) {
    if (!f.writing()) wanted = with_labels;
    f.toggle(text, wanted, {.has_default = false});
    if (f.peek(text.key) == nullptr || !wanted || possible) return;
    f.fault(text.key, fmt::format("there are no images to label; expected {} as well", pictures));
  };
  label({"shadow", "Shadow masks",
         "Masks of the shadows with the polar and Cartesian masks; needs polar or cartesian; left "
         "out: true with polar or cartesian"},
        with_labels, "polar or cartesian", selection.shadow);
  label({"amodal", "Amodal masks",
         "Masks of every instance with its hidden parts, in the annotations of all images, and the "
         "hidden fraction of it; left out: true with polar or cartesian"},
        with_labels || selection.png, "polar, cartesian or png", selection.amodal);
}

void layers_fields(Fields& f, OutputSpec& output) {
  if (!f.begin_switch({"layers", "Layers",
                       "Time series of the signal components noise, volumes, targets and "
                       "background, which add up to the whole; a map of options switches them on"},
                      output.selection.layers)) {
    return;
  }
  std::vector<std::string> targets = output.layer_targets.value_or(std::vector<std::string>{});
  if (f.list({"targets", "Targets",
              "Names and classes of the objects and point targets in the layer target; left out: "
              "all but planes, terrain and inward-facing shapes"},
             targets, {}, written_if(output.layer_targets.has_value(), {.has_default = false}),
             [&](const std::string& at, std::string& name) { f.text(at, name); })) {
    output.layer_targets = std::move(targets);
  }
  f.end();
}

void packing_field(Fields& f, OutputSelection& selection) {
  f.renamed("pack", "one_file_per");
  f.choice<bool>({"one_file_per", "One file per",
                  "ping: each ping has files of its own; sequence: arrays hold all pings of a "
                  "sequence"},
                 selection.packed, {{"ping", false}, {"sequence", true}});
  if (!selection.packed || !selection.timeseries_exr) return;
  f.fault("one_file_per",
          "`sequence` stores arrays, but output.timeseries selects EXR files of each ping; "
          "expected timeseries npy or none with it");
}

// This is the last key, because without pings it disables the files that the other keys select.
void pings_field(Fields& f, OutputSelection& selection) {
  f.toggle({"pings", "Files of pings",
            "Whether pings have files; false writes none, whatever the other keys select, and "
            "needs statistics"},
           selection.pings, written_if(selection.statistics));
  if (f.writing() || selection.pings) return;
  if (!selection.statistics) {
    f.fault("pings",
            "false without statistics leaves nothing to write; expected statistics: true with it");
  }
  OutputSelection none = no_outputs();
  none.statistics = selection.statistics;
  none.statistics_lags = selection.statistics_lags;
  none.statistics_within_db = selection.statistics_within_db;
  none.world = selection.world;
  none.pings = false;
  selection = none;
}

// Adds all names and classes below the node, including those of alternatives.
void add_names(const Node& node, std::vector<std::string>& words) {
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const bool is_map = node.kind == NodeKind::map;
    const bool named = is_map && (node.keys[i].text == "name" || node.keys[i].text == "class");
    if (named && node.items[i].kind == NodeKind::scalar) words.push_back(node.items[i].text);
    add_names(node.items[i], words);
  }
}

// Returns the name of the entry with a count that `name` may be a copy of.
std::string without_number(const std::string& name) {
  const auto digits = name.find_last_not_of("0123456789");
  if (digits == std::string::npos || digits + 1 == name.size() || name[digits] != '_') return name;
  return name.substr(0, digits);
}

void image_fields(Fields& f, OutputSpec& output) {
  f.toggle({"polar", "Polar images", "EXR images and masks in polar geometry"},
           output.selection.polar);
  if (f.begin_switch({"cartesian", "Cartesian images",
                      "Masks and 8-bit display images seen from above, and the map from their "
                      "pixels to those of polar images; a map of options switches them on"},
                     output.selection.cartesian)) {
    f.integer(
        {"height_px", "Height", "Rows of the image; the number of columns follows from the fan"},
        output.cartesian_height_px, 1, kMaxImageHeight);
    f.toggle({"exr", "Float planes",
              "Whether Cartesian images hold the level and the other float planes too, as EXR or, "
              "in packed sequences, as arrays; the map gives the same values from polar images"},
             output.selection.cartesian_exr, written_if(output.selection.cartesian_exr));
    f.end();
  }
}

// The switches of planes that their rows describe.
void plane_switches(Fields& f, OutputSelection& selection) {
  for (const OutputFlag& flag : kOutputFlags) {
    if (flag.title == nullptr) continue;
    bool& on = selection.*flag.member;
    f.toggle({flag.name, flag.title, flag.meaning}, on, written_if(on));
    if (!on || flag.needs == nullptr || selection.*flag.needs) continue;
    f.fault(flag.name, fmt::format("there are no {0} images for it; expected {0} as well",
                                   flag_of(flag.needs)->name));
  }
}

void point_motion_fields(Fields& f, OutputSelection& selection) {
  if (!f.begin_switch({"motion", "Motion",
                       "EXR and PNG files next to polar images with the surface point of each "
                       "pixel, its displacement to another ping, and whether that ping sees it; "
                       "needs polar; a map of options switches them on"},
                      selection.motion, written_if(selection.motion))) {
    return;
  }
  f.integer({"pings", "Pings",
             "Number of pings from this one to the other; negative: the other one is earlier"},
            selection.motion_pings, 1 - kMaxPings, kMaxPings - 1);
  if (selection.motion_pings == 0) {
    f.fault("pings", "0 is the ping itself; expected another number");
  }
  f.end();
}

void check_point_motion(Fields& f, const Scenario& scenario) {
  const OutputSelection& selection = scenario.output.selection;
  if (selection.motion && !selection.polar) {
    f.fault("motion", "there are no polar images for it; expected polar as well");
  }
  const auto refuse = [&](bool on, const char* key) {
    if (!on) return;
    if (scenario.water.profile || scenario.motion_within_ping) {
      f.fault(key, fmt::format("points are followed along straight lines between fixed poses; "
                               "expected {} without water.profile and motion_within_ping",
                               key));
    } else if (selection.statistics) {
      f.fault(key, fmt::format("with statistics all pings show one scene at rest; expected {} or "
                               "statistics, but not both",
                               key));
    }
  };
  refuse(selection.motion, "motion");
  refuse(selection.covisibility, "covisibility");
}

void elevation_fields(Fields& f, OutputSpec& output) {
  OutputSelection& selection = output.selection;
  if (f.begin_switch({"elevation", "Echo over elevation",
                      "List of the echo power in each range bin, beam cell and step of elevation, "
                      "before pulse and beams spread it; a map of options switches it on"},
                     selection.elevation, written_if(selection.elevation))) {
    f.number(
        {"step_deg", "Step", "Width of the steps, of which one begins at the plane of the sonar"},
        output.elevation_step_deg, kElevationStep);
    f.boolean(
        {"volumes", "Volumes",
         "Whether the list has the reverberation of volumes, which is in most bins and steps"},
        selection.elevation_volumes);
    f.end();
  }
  selection.elevation_step_rad = radians(output.elevation_step_deg);
}

void statistics_fields(Fields& f, OutputSelection& selection) {
  if (!f.begin_switch(
          {"statistics", "Statistics",
           "Moments of every pixel over the pings of a sequence, which are independent "
           "realizations of one scene: everything must be at rest, and scattering.speckle must be "
           "per_ping; a map of options switches them on"},
          selection.statistics, written_if(selection.statistics))) {
    return;
  }
  const OutputSelection plain;
  f.integer({"lags", "Lags",
             "Correlations of pixels up to so many samples and beams apart, over all pooled pixels "
             "of a beam; 0: none"},
            selection.statistics_lags, 0, kMostLags,
            written_if(selection.statistics_lags != plain.statistics_lags));
  f.number({"within_db", "Pooled pixels",
            "Histogram and lags pool the pixels whose expected intensity is so far below the "
            "largest, or less",
            "dB"},
           selection.statistics_within_db, kWithinDb,
           written_if(selection.statistics_within_db != plain.statistics_within_db));
  f.end();
}

void extra_fields(Fields& f, OutputSelection& selection) {
  f.toggle({"front", "Front views",
            "Maps over elevation and azimuth of the surface that each ray meets first: range, "
            "normal, backscatter, instance and class"},
           selection.front, written_if(selection.front));
  f.toggle({"polygons", "Polygons",
            "Closed polygons along the pixel edges of every mask, with the masks"},
           selection.polygons);
  f.toggle({"scatterers", "Scatterers", "List of the echoes from which the time series is made"},
           selection.scatterers);
  f.toggle({"points", "Point clouds",
            "Points on the surfaces that each ping hits, as a PLY point cloud"},
           selection.points);
}

}  // namespace

void output_fields(Fields& f, Scenario& scenario) {
  OutputSpec& output = scenario.output;
  OutputSelection& selection = output.selection;
  timeseries_field(f, selection);
  image_fields(f, output);
  png_fields(f, output);
  hidden_label_fields(f, selection);
  const bool images = selection.polar || selection.cartesian;
  const bool more_paths = has_more_paths(scenario);
  if (!f.writing()) selection.multipath = more_paths && images;
  f.toggle({"multipath", "Multipath masks",
            "Masks of the pixels in which multipath echoes are stronger than direct ones; needs "
            "multipath, bounces or a wall; left out: true with these and polar or cartesian"},
           selection.multipath, written_if(more_paths, {.has_default = false}));
  plane_switches(f, selection);
  point_motion_fields(f, selection);
  f.toggle({"covisibility", "Covisibility",
            "Matrix of each sequence with the share of what a ping sees that another sees as well; "
            "for trajectories of up to 4000 pings"},
           selection.covisibility, written_if(selection.covisibility));
  elevation_fields(f, output);
  extra_fields(f, selection);
  camera_output_fields(f, scenario, selection);
  layers_fields(f, output);
  packing_field(f, selection);
  f.toggle({"channels", "Element channels",
            "Signal of each element of an array; needs sonar.receiver.mode array"},
           selection.channels, written_if(selection.channels));
  scene_file_fields(f, output);
  statistics_fields(f, selection);
  check_point_motion(f, scenario);
  pings_field(f, selection);
  if (!selection.multipath || (more_paths && images)) return;
  f.fault("multipath",
          images ? "the scenario has no multipath; expected only with multipath, bounces or a wall"
                 : "there are no images to label; expected polar or cartesian as well");
}

std::vector<std::string> layer_target_words(const Value& root) {
  std::vector<std::string> words = {ObjectSpec{}.class_name, PointTargetSpec{}.class_name};
  for (const char* section : {"objects", "point_targets"}) {
    if (const auto list = child(root, section)) add_names(*list->node, words);
  }
  return words;
}

void check_layer_targets(Faults& faults, const Value& root, const std::vector<std::string>& words) {
  const auto output = child(root, "output");
  const auto layers = output ? child(*output, "layers") : std::nullopt;
  const auto targets = layers ? child(*layers, "targets") : std::nullopt;
  if (!targets || targets->node->kind != NodeKind::list) return;
  const std::vector<std::string_view> known(words.begin(), words.end());
  for (std::size_t i = 0; i < targets->node->items.size(); ++i) {
    const Value word = item(*targets, i);
    const std::string& text = word.node->text;
    const auto is_known = [&](const std::string& name) {
      return std::find(words.begin(), words.end(), name) != words.end();
    };
    if (word.node->kind != NodeKind::scalar || is_known(text) || is_known(without_number(text))) {
      continue;
    }
    add_fault(faults, word.place, word.path,
              fmt::format("{} is not an object, a point target or a class of them{}; expected "
                          "their names and classes (volumes have a layer of their own)",
                          shown(text), hint(text, known)));
  }
}

}  // namespace ensonify
