#include "export/export.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "export/job.h"
#include "formats/csv.h"
#include "formats/files.h"
#include "formats/output_place.h"
#include "sweep/index.h"
#include "sweep/status.h"

namespace ensonify {
namespace fs = std::filesystem;

// Each in a file with its name.
using Exporter = Status(const ExportJob& job, const std::filesystem::path& target);
Exporter write_coco_folder, write_coco_panoptic, write_crops, write_yolo, write_voc,
    write_index_mask, write_tum, write_hdf5, write_webdataset, write_ply, write_a2fnet, write_aris,
    write_oculus, write_mcap, write_sonar_netcdf4, write_neusis, write_mot, write_pairs,
    write_sonic, write_sdpr, write_nerfstudio, write_colmap, write_kitti;

namespace {

constexpr ExportFormat kFormats[] = {
    {"coco", "COCO by split: images and annotations/instances_SPLIT.json",
     kSimulated | kListsObjects | kOneOfRuns, "--view, --render", write_coco_folder},
    {"coco_panoptic", "COCO panoptic by split: images, segments as PNG and JSON, class masks",
     kSimulated | kOneOfRuns, "--view, --render", write_coco_panoptic},
    {"yolo", "Ultralytics: images, labels with outlines or boxes, data.yaml",
     kSimulated | kListsObjects | kOneOfRuns, "--view, --labels, --render", write_yolo},
    {"voc", "PASCAL VOC: boxes as XML, indexed masks, image sets",
     kSimulated | kListsObjects | kOneOfRuns, "--view, --render", write_voc},
    {"crops", "one image per object, in folders by split and class",
     kSimulated | kListsObjects | kGrayImages | kOneOfRuns, "--view, --margin-px, --render",
     write_crops},
    {"index_mask", "images with class and instance masks, in train, val and test",
     kSimulated | kOneOfRuns, "--view, --render", write_index_mask},
    {"tum", "TUM trajectories of the sonar and of each object", kOfCamera | kOfNavigation, "",
     write_tum},
    {"hdf5", "one HDF5 file: arrays stacked over pings, one group per sequence", kIsFile,
     "--stack, --pad", write_hdf5},
    {"webdataset", "tar shards of images, masks, time series and labels",
     kListsObjects | kOneOfRuns, "--view, --shard-size-mb, --render", write_webdataset},
    {"a2fnet", "A2FNet: polar images, inverse ranges of front views, elevations, and their lists",
     kSimulated | kOneOfRuns, "", write_a2fnet},
    {"ply", "one point cloud per ping, from scatterers/", kSimulated, "", write_ply},
    {"mcap", "one MCAP file per sequence, with ROS 2 messages: images, labels, points and poses",
     kListsObjects | kPolarImages | kGrayImages | kOfNavigation, "--render, --one-file",
     write_mcap},
    {"sonar_netcdf4",
     "one SONAR-netCDF4 file per sequence: complex beams with the numbers of the sonar equation",
     kSimulated, "", write_sonar_netcdf4},
    {"aris", "one .aris log per sequence: 8-bit counts of an ARIS", 0, "--full-scale-db",
     write_aris},
    {"oculus", "one .oculus log per sequence: amplitudes of an Oculus", 0, "--full-scale-db",
     write_oculus},
    {"neusis", "amplitude images with poses as pickles, and Config.json, by sequence", kSimulated,
     "--full-scale-db", write_neusis},
    {"sonic", "amplitude images and poses as NPY, and pairs of overlapping pings", kSimulated,
     "--full-scale-db", write_sonic},
    {"sdpr", "polar images as JPEG, and poses as text, by split",
     kPolarImages | kGrayImages | kOneOfRuns, "--render", write_sdpr},
    {"mot", "MOTChallenge: images, tracks with boxes, seqinfo.ini, by sequence",
     kSimulated | kListsObjects, "--view, --render", write_mot},
    {"pairs", "8-bit images with and without speckle and noise, for denoisers",
     kSimulated | kGrayImages | kExactImages | kOneOfRuns, "--view, --render", write_pairs},
    {"nerfstudio", "the camera's images and depth, and transforms.json, by sequence",
     kSimulated | kOfCamera, "", write_nerfstudio},
    {"colmap", "the camera's images, and its poses as a COLMAP text model, by sequence",
     kSimulated | kOfCamera, "", write_colmap},
    {"kitti", "KITTI odometry: the camera's images, depth, calib.txt and poses, by sequence",
     kSimulated | kOfCamera, "", write_kitti},
};

// The given options that the format does not accept.
std::string unwanted_options(const ExportFormat& format, const ExportOptions& options) {
  const std::pair<std::string_view, bool> given[] = {
      {"--view", options.view.has_value()},
      {"--labels", options.labels.has_value()},
      {"--stack", options.stack},
      {"--pad", options.pad},
      {"--margin-px", options.margin_px.has_value()},
      {"--shard-size-mb", options.shard_size_mb.has_value()},
      {"--full-scale-db", options.full_scale_db.has_value()},
      {"--one-file", options.one_file},
      {"--render", options.render.has_value()}};
  const std::pair<std::string_view, bool> of_objects[] = {
      {"--classes", options.classes.has_value()},
      {"--exclude", !options.exclude.empty()},
      {"--min-pixels", options.min_pixels.has_value()},
      {"--min-visible", options.min_visible.has_value()}};
  std::string unwanted;
  const auto refuse = [&](std::string_view name) {
    unwanted += (unwanted.empty() ? "" : ", ") + std::string(name);
  };
  for (const auto& [name, is_given] : given) {
    const bool taken = std::string_view(format.options).find(name) != std::string_view::npos;
    if (is_given && !taken) refuse(name);
  }
  for (const auto& [name, is_given] : of_objects) {
    if (is_given && !format.has(kListsObjects)) refuse(name);
  }
  return unwanted;
}

Status check_options(const ExportFormat& format, const ExportOptions& options) {
  const std::string unwanted = unwanted_options(format, options);
  if (!unwanted.empty()) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: not an option of --format {}{}{}", unwanted, format.name,
                             *format.options != '\0' ? ", which takes " : "", format.options)};
  }
  if (options.pad && !options.stack) {
    return Error{ErrorKind::usage, "--pad: works only with --stack"};
  }
  return {};
}

// Keeps only the sequences of the requested split.
Status keep_split(const ExportOptions& options, StoredDataset& dataset) {
  if (!options.split) return {};
  std::erase_if(dataset.sequences,
                [&](const StoredSequenceRow& row) { return row.split != *options.split; });
  if (!dataset.sequences.empty()) return {};
  return Error{ErrorKind::usage, fmt::format("--split {}: {} has no sequence in this split",
                                             *options.split, options.dataset.string())};
}

// The render whose images are exported. It must have all images, and their pixels must match the
// masks. Absent if not requested.
Result<std::optional<RenderManifest>> render_of(const ExportFormat& format,
                                                const StoredDataset& dataset,
                                                const ExportOptions& options) {
  std::optional<RenderManifest> none;
  if (!options.render) return none;
  auto render = read_render(dataset, *options.render);
  if (!render) return render.error();
  const auto refused = [&](const std::string& what) {
    return Error{ErrorKind::usage, fmt::format("--render {}: {}", *options.render, what)};
  };
  if (render->display.flip != Flip::none) {
    return refused("its images are flipped, but masks and boxes are not; render without --flip");
  }
  if (!render->part.is_whole()) {
    return refused(
        "shows a part of the pixels or decimates them, but masks and boxes are of all; render "
        "without --range, --every-sample and --every-beam");
  }
  const std::string view = view_name(
      format.has(kPolarImages) ? ImageView::polar : options.view.value_or(ImageView::cartesian));
  if (std::find(render->views.begin(), render->views.end(), view) == render->views.end()) {
    return refused(fmt::format("has no {} images; render without --view", view));
  }
  if (format.has(kGrayImages) && !render->display.color_map.empty()) {
    return refused("is in color, but this format holds 8-bit levels; render without --color-map");
  }
  if (format.has(kExactImages) && render->jpeg_quality > 0) {
    return refused(
        "has JPEG files, which are not the exact levels that this format holds; render without "
        "--jpeg-quality");
  }
  if (render->sequences.size() != dataset.sequences.size()) {
    return refused("lacks sequences of the data set; render without --sequences");
  }
  return std::optional(std::move(*render));
}

// Refuses a recording, a camera or sensors for a format whose content they do not have.
Status unless_lacking(const ExportFormat& format, const StoredDataset& dataset) {
  if (dataset.sequences.empty()) return {};
  const auto first = read_sequence(dataset, dataset.sequences.front());
  if (!first) return {};
  const SequenceInfo& info = first->manifest.info;
  const bool is_recording = !info.output.labels;
  const auto fits = [&](const ExportFormat& other) {
    if (is_recording) return !other.has(kSimulated);
    return is_sonar(info) ||
           other.has(info.instrument == InstrumentKind::camera ? kOfCamera : kOfNavigation);
  };
  if (fits(format)) return {};
  std::string others;
  for (const ExportFormat& other : kFormats) {
    if (fits(other)) others += (others.empty() ? "" : ", ") + std::string(other.name);
  }
  const std::string what =
      is_recording ? "a recording" : fmt::format("{} of a rig", name_of(info.instrument));
  return Error{
      ErrorKind::usage,
      fmt::format("{}: {}, which lacks what --format {} needs ({}); expected one of {}",
                  dataset.dir.string(), what, format.name,
                  is_recording ? "labels, time series or the vertical fan" : "a sonar", others)};
}

// A data set, and what of it is exported.
struct Source {
  StoredDataset dataset;
  std::optional<RenderManifest> render;
};

Result<Source> open_source(const ExportFormat& format, const ExportOptions& options) {
  auto dataset = open_dataset(options.dataset);
  if (!dataset) return dataset.error();
  if (const Status fit = unless_lacking(format, *dataset); !fit) return fit.error();
  auto render = render_of(format, *dataset, options);
  if (!render) return render.error();
  if (const Status left = keep_split(options, *dataset); !left) return left.error();
  return Source{std::move(*dataset), std::move(*render)};
}

void count(const StoredDataset& dataset, ExportReport& report) {
  report.sequences += dataset.sequences.size();
  for (const StoredSequenceRow& row : dataset.sequences) report.pings += row.pings();
}

Result<ExportReport> export_to(const ExportFormat& format, const ExportOptions& options) {
  const auto source = open_source(format, options);
  if (!source) return source.error();
  auto objects = object_filter(source->dataset, options);
  if (!objects) return objects.error();
  auto place = OutputPlace::open(options.output, !format.has(kIsFile), options.dataset);
  if (!place) return place.error();
  const ExportJob job{source->dataset, options, *objects, source->render};
  if (const Status written = format.write(job, place->temporary()); !written) {
    return written.error();
  }
  if (const Status committed = place->commit(); !committed) return committed.error();
  ExportReport report;
  count(source->dataset, report);
  return report;
}

// The runs of the plan that are done in the table of the sweep, and that table.
struct DoneRuns {
  Plan runs;
  std::string table;
  std::size_t left_out = 0;
};

Result<DoneRuns> done_runs(const fs::path& dir) {
  const auto plan = read_plan(dir);
  if (!plan) return plan.error();
  std::error_code error;
  if (!*plan || !fs::exists(dir / kRunsFile, error)) {
    return Error{
        ErrorKind::usage,
        fmt::format("{}: this sweep has no {}; repeat its command until all runs are done, "
                    "or write the table of those that are: ensonify sweep SWEEP -o {} "
                    "--finalize --partial",
                    dir.string(), kRunsFile, dir.string())};
  }
  auto table = read_file(dir / kRunsFile);
  if (!table) return table.error();
  const auto rows = csv_rows(*table);
  const auto status = std::find(rows.front().begin(), rows.front().end(), "status");
  const auto column = static_cast<std::size_t>(status - rows.front().begin());
  std::set<std::string> done;
  for (const auto& row : rows) {
    if (column < row.size() && row[column] == state_name(RunState::done)) done.insert(row[0]);
  }
  DoneRuns runs{{}, std::move(*table), 0};
  for (const PlannedRun& run : **plan) {
    if (done.contains(run.id)) runs.runs.push_back(run);
  }
  runs.left_out = (*plan)->size() - runs.runs.size();
  if (!runs.runs.empty()) return runs;
  return Error{ErrorKind::usage, fmt::format("{}: no run of this sweep is done", dir.string())};
}

ExportOptions of_run(const ExportOptions& options, const PlannedRun& run) {
  ExportOptions one = options;
  one.dataset = options.dataset / run_folder(run.id);
  return one;
}

// Class ids must mean the same in all images.
Status check_classes(const std::vector<std::string>& first, const StoredDataset& other,
                     const ExportFormat& format) {
  if (first == other.classes) return {};
  return Error{ErrorKind::usage,
               fmt::format("{}: has the classes {}, but the first run has {}; --format {} needs "
                           "the same in all runs: list them in the base scenario (`classes`)",
                           other.dir.string(), fmt::join(other.classes, ", "),
                           fmt::join(first, ", "), format.name)};
}

Status export_at_once(const ExportFormat& format, const ExportOptions& options, SweepRuns& sweep,
                      const fs::path& target, ExportReport& report) {
  auto source = open_source(format, of_run(options, sweep.runs.front()));
  if (!source) return source.error();
  const std::vector<std::string> classes = source->dataset.classes;
  sweep.open = [&](const PlannedRun& run) -> Status {
    auto next = open_source(format, of_run(options, run));
    if (!next) return next.error();
    if (Status same = check_classes(classes, next->dataset, format); !same) return same;
    *source = std::move(*next);
    sweep.current = &run;
    count(source->dataset, report);
    return {};
  };
  const auto objects = object_filter(source->dataset, options);
  if (!objects) return objects.error();
  return format.write({source->dataset, options, *objects, source->render, &sweep}, target);
}

Status export_each(const ExportFormat& format, const ExportOptions& options, const Plan& runs,
                   const fs::path& target, ExportReport& report) {
  for (const PlannedRun& run : runs) {
    ExportOptions one = of_run(options, run);
    one.output = target / (run.id + (format.has(kIsFile) ? ".h5" : ""));
    const auto exported = export_to(format, one);
    if (!exported) return exported.error();
    report.sequences += exported->sequences;
    report.pings += exported->pings;
  }
  return {};
}

Result<ExportReport> export_sweep(const ExportFormat& format, const ExportOptions& options) {
  auto done = done_runs(options.dataset);
  if (!done) return done.error();
  auto place = OutputPlace::open(options.output, true, options.dataset);
  if (!place) return place.error();
  ExportReport report;
  report.runs = done->runs.size();
  report.left_out = done->left_out;
  SweepRuns sweep;
  sweep.runs = std::move(done->runs);
  const Status written = format.has(kOneOfRuns)
                             ? export_at_once(format, options, sweep, place->temporary(), report)
                             : export_each(format, options, sweep.runs, place->temporary(), report);
  if (!written) return written.error();
  const Status listed = write_whole(place->temporary() / kRunsFile, done->table);
  if (!listed) return listed.error();
  if (const Status committed = place->commit(); !committed) return committed.error();
  return report;
}

}  // namespace

std::span<const ExportFormat> export_formats() { return kFormats; }

const ExportFormat* find_export_format(std::string_view name) {
  const auto found = std::find_if(std::begin(kFormats), std::end(kFormats),
                                  [&](const ExportFormat& f) { return f.name == name; });
  return found == std::end(kFormats) ? nullptr : found;
}

Result<ExportReport> export_dataset(const ExportFormat& format, const ExportOptions& options) {
  if (const Status fit = check_options(format, options); !fit) return fit.error();
  return without_exceptions("exporting " + options.dataset.string(), [&]() -> Result<ExportReport> {
    const auto sweep = read_sweep_head(options.dataset);
    if (!sweep) return sweep.error();
    return *sweep ? export_sweep(format, options) : export_to(format, options);
  });
}

}  // namespace ensonify
