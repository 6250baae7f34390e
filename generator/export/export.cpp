#include "export/export.h"

#include <fmt/format.h>

#include <algorithm>

#include "export/job.h"
#include "formats/files.h"
#include "formats/output_place.h"

namespace ensonify {

// Each in a file with its name.
using Exporter = Status(const ExportJob& job, const std::filesystem::path& target);
Exporter write_coco_folder, write_coco_panoptic, write_crops, write_yolo, write_voc,
    write_index_mask, write_tum, write_hdf5, write_webdataset, write_ply, write_a2fnet, write_aris,
    write_oculus, write_mcap, write_sonar_netcdf4, write_neusis, write_mot, write_pairs,
    write_sonic, write_sdpr;

namespace {

constexpr ExportFormat kFormats[] = {
    {"coco", "COCO by split: images and annotations/instances_SPLIT.json",
     kSimulated | kListsObjects, "--view, --render", write_coco_folder},
    {"coco_panoptic", "COCO panoptic by split: images, segments as PNG and JSON, class masks",
     kSimulated, "--view, --render", write_coco_panoptic},
    {"yolo", "Ultralytics: images, labels with outlines or boxes, data.yaml",
     kSimulated | kListsObjects, "--view, --labels, --render", write_yolo},
    {"voc", "PASCAL VOC: boxes as XML, indexed masks, image sets", kSimulated | kListsObjects,
     "--view, --render", write_voc},
    {"crops", "one image per object, in folders by split and class",
     kSimulated | kListsObjects | kGrayImages, "--view, --margin-px, --render", write_crops},
    {"index_mask", "images with class and instance masks, in train, val and test", kSimulated,
     "--view, --render", write_index_mask},
    {"tum", "TUM trajectories of the sonar and of each object", 0, "", write_tum},
    {"hdf5", "one HDF5 file: arrays stacked over pings, one group per sequence", kIsFile,
     "--stack, --pad", write_hdf5},
    {"webdataset", "tar shards of images, masks, time series and labels", kListsObjects,
     "--view, --shard-size-mb, --render", write_webdataset},
    {"a2fnet", "A2FNet: polar images, inverse ranges of front views, elevations, and their lists",
     kSimulated, "", write_a2fnet},
    {"ply", "one point cloud per ping, from scatterers/", kSimulated, "", write_ply},
    {"mcap", "one MCAP file per sequence, with ROS 2 messages: images, labels, points and poses",
     kListsObjects | kPolarImages | kGrayImages, "--render, --one-file", write_mcap},
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
    {"sdpr", "polar images as JPEG, and poses as text, by split", kPolarImages | kGrayImages,
     "--render", write_sdpr},
    {"mot", "MOTChallenge: images, tracks with boxes, seqinfo.ini, by sequence",
     kSimulated | kListsObjects, "--view, --render", write_mot},
    {"pairs", "8-bit images with and without speckle and noise, for denoisers",
     kSimulated | kGrayImages | kExactImages, "--view, --render", write_pairs},
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

// Refuses a recording for a format whose content it does not have.
Status unless_recorded(const ExportFormat& format, const StoredDataset& dataset) {
  if (!format.has(kSimulated) || dataset.sequences.empty()) return {};
  const auto first = read_sequence(dataset, dataset.sequences.front());
  if (!first || first->manifest.info.output.labels) return {};
  std::string others;
  for (const ExportFormat& other : kFormats) {
    if (!other.has(kSimulated)) others += (others.empty() ? "" : ", ") + std::string(other.name);
  }
  return Error{ErrorKind::usage,
               fmt::format("{}: a recording, which lacks what --format {} needs (labels, time "
                           "series or the vertical fan); expected one of {}",
                           dataset.dir.string(), format.name, others)};
}

Result<ExportReport> export_to(const ExportFormat& format, const ExportOptions& options) {
  auto dataset = open_dataset(options.dataset);
  if (!dataset) return dataset.error();
  if (const Status fit = unless_recorded(format, *dataset); !fit) return fit.error();
  const auto render = render_of(format, *dataset, options);
  if (!render) return render.error();
  if (const Status left = keep_split(options, *dataset); !left) return left.error();
  auto objects = object_filter(*dataset, options);
  if (!objects) return objects.error();
  auto place = OutputPlace::open(options.output, !format.has(kIsFile), options.dataset);
  if (!place) return place.error();
  const ExportJob job{*dataset, options, *objects, *render};
  if (const Status written = format.write(job, place->temporary()); !written) {
    return written.error();
  }
  if (const Status committed = place->commit(); !committed) return committed.error();
  ExportReport report;
  report.sequences = dataset->sequences.size();
  for (const StoredSequenceRow& row : dataset->sequences) report.pings += row.pings();
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
  return without_exceptions("exporting " + options.dataset.string(),
                            [&] { return export_to(format, options); });
}

}  // namespace ensonify
