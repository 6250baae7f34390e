#include "render/render.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <optional>
#include <system_error>
#include <vector>

#include "core/parallel.h"
#include "dataset/layout.h"
#include "dataset/read_pictures.h"
#include "dataset/render_manifest.h"
#include "figure/drawing.h"
#include "formats/output_place.h"
#include "labels/display.h"
#include "render/shown_images.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// Number of sequences that determine the limits if those of the data set do not apply.
constexpr std::size_t kLimitSequences = 4;

struct Job {
  const RenderOptions& options;
  StoredDataset dataset;
  std::vector<StoredSequenceRow> rows;
  std::vector<ImageView> views;
  Display display;
  fs::path folder;

  bool sees(ImageView view) const {
    return std::find(views.begin(), views.end(), view) != views.end();
  }
};

// A lane's results for a sequence, in the order of its pings.
struct Rendered {
  Status status;
  std::vector<FileEntry> files;
  DisplayCounts counts;
  std::optional<SequencePart> part;
};

Error usage(const RenderOptions& options, const std::string& what) {
  return {ErrorKind::usage, options.dataset.string() + ": " + what};
}

Status check_part(const RenderOptions& options) {
  const ShownPart& part = options.part;
  if (options.jpeg_quality > 0 && !options.display.color_map.empty()) {
    return Error{ErrorKind::usage,
                 "--color-map: JPEG files have no palette, from which gray levels could be read; "
                 "leave out --jpeg-quality or --color-map"};
  }
  if (part.range_m && !(0 <= (*part.range_m)[0] && (*part.range_m)[0] < (*part.range_m)[1] &&
                        std::isfinite((*part.range_m)[1]))) {
    return Error{ErrorKind::usage,
                 fmt::format("--range {:g}:{:g}: expected FROM:TO in m, FROM less "
                             "than TO and not negative",
                             (*part.range_m)[0], (*part.range_m)[1])};
  }
  if (part.decimation == Decimation::max && !part.decimates()) {
    return Error{ErrorKind::usage,
                 "--decimation max: has no effect on single pixels; use it with --every-sample or "
                 "--every-beam"};
  }
  return {};
}

Status check_options(const RenderOptions& options) {
  const Display& display = options.display;
  if (!is_render_name(options.name)) {
    return Error{ErrorKind::usage,
                 fmt::format("--name {}: expected at most 64 letters, digits, '-', '_' and '.', "
                             "not starting with '.'",
                             options.name)};
  }
  if (options.limits_db && !((*options.limits_db)[0] < (*options.limits_db)[1])) {
    return Error{ErrorKind::usage,
                 fmt::format("--db {:g}:{:g}: the lower limit comes first; expected MIN:MAX in dB",
                             (*options.limits_db)[0], (*options.limits_db)[1])};
  }
  if (display.gamma != 1 && display.scale == GreyScale::db) {
    return Error{ErrorKind::usage,
                 "--gamma: is a power of the amplitude; use it with --scale amplitude"};
  }
  if (!display.color_map.empty() && find_colour_map(display.color_map) == nullptr) {
    return Error{ErrorKind::usage, fmt::format("--color-map {}: unknown", display.color_map)};
  }
  return check_part(options);
}

Result<std::vector<StoredSequenceRow>> rows_of(const RenderOptions& options,
                                               const StoredDataset& dataset) {
  std::vector<StoredSequenceRow> rows = dataset.sequences;
  if (options.sequences) {
    std::erase_if(rows, [&](const StoredSequenceRow& row) {
      return row.sequence < options.sequences->first || row.sequence >= options.sequences->second;
    });
  }
  if (rows.empty()) return usage(options, "has none of these sequences");
  return rows;
}

// Views of the first sequence; all have the same.
Result<std::vector<ImageView>> views_of(const RenderOptions& options,
                                        const StoredSequence& sequence) {
  const CatalogueRow& level = plane_row(ImageView::polar, "level_db");
  if (!sequence.has(level)) {
    return usage(options, fmt::format("its pings have no polar levels ({}), which rendering needs; "
                                      "generate the data set with {}",
                                      level.file, level.maker));
  }
  const bool has_map = sequence.cartesian_height > 0;
  if (options.view == ImageView::cartesian && !has_map) {
    return usage(options, "has no Cartesian grid; use --view polar");
  }
  std::vector<ImageView> views;
  if (options.view != ImageView::cartesian) views.push_back(ImageView::polar);
  if (options.view != ImageView::polar && has_map) views.push_back(ImageView::cartesian);
  return views;
}

bool labels_of(const StoredSequence& sequence) { return sequence.manifest.info.output.labels; }

Result<std::array<double, 2>> limits_of(const Job& job) {
  const RenderOptions& options = job.options;
  if (options.limits_db) return *options.limits_db;
  const auto& own = job.dataset.manifest.png;
  if (own && same_tvg(*own, options.display)) return own->limits_db;
  EchoLevels levels;
  for (std::size_t i = 0; i < std::min(kLimitSequences, job.rows.size()); ++i) {
    const auto sequence = read_sequence(job.dataset, job.rows[i]);
    if (!sequence) return sequence.error();
    const auto pixels = read_picture(
        job.dataset, *sequence, ImageView::polar, job.rows[i].first_ping,
        labels_of(*sequence) ? PlaneNames{"clean_db", "elevation_rad"} : PlaneNames{"level_db"});
    if (!pixels) return pixels.error();
    LabelledImage polar;
    static_cast<ImagePlanes&>(polar) = *pixels;
    polar.columns = static_cast<int>(sequence->beams);
    levels.add(echo_levels(sequence_table(options.display, *sequence), polar,
                           sequence->manifest.info.noise_power_pa2));
  }
  return default_limits_db(std::move(levels));
}

Status write_image(const Job& job, const StoredSequence& sequence, std::uint32_t ping,
                   ImageView view, const GreyImage& image, FileEntry& entry) {
  const std::uint32_t quality = job.options.jpeg_quality;
  const auto bytes = encode_image(flipped(image, job.display.flip), job.display, quality);
  if (!bytes) return bytes.error();
  entry = {render_file(view, sequence.row.sequence, ping, quality > 0), bytes->size(),
           sha256_hex(*bytes)};
  return write_whole(job.folder / entry.path, *bytes);
}

// `files`: of the ping, one for each view.
Status render_ping(const Job& job, const StoredSequence& sequence, const SequenceDisplay& shown,
                   std::uint32_t ping, std::span<FileEntry> files, DisplayCounts& counts) {
  if (job.options.stop && job.options.stop()) {
    return Error{ErrorKind::interrupted, "interrupted; run the same command to start again"};
  }
  const auto pixels =
      read_picture(job.dataset, sequence, ImageView::polar, ping, {"level_db", "elevation_rad"});
  if (!pixels) return pixels.error();
  const std::uint64_t count = sequence.samples * sequence.beams;
  const bool labelled = pixels->elevation_rad.size() == count || !labels_of(sequence);
  if (pixels->level_db.size() != count || !labelled) {
    return damaged(job.dataset.dir / layout::sequence_folder(sequence.row.sequence),
                   "has no polar levels, but other sequences have them");
  }
  const std::vector<std::uint32_t> blocks =
      shown.part ? block_pixels(*shown.part, pixels->level_db) : std::vector<std::uint32_t>{};
  const DisplayedImage polar = shown_polar(sequence, shown, *pixels, blocks);
  counts = polar.counts;
  const auto cartesian = [&] { return shown_cartesian(sequence, shown, *pixels, blocks, polar); };
  for (std::size_t i = 0; i < job.views.size(); ++i) {
    const bool is_polar = job.views[i] == ImageView::polar;
    Status written = write_image(job, sequence, ping, job.views[i],
                                 is_polar ? polar.grey : cartesian(), files[i]);
    if (!written) return written;
  }
  return {};
}

// Whether every sequence has the part, before anything is written.
Status check_parts(const Job& job) {
  for (const StoredSequenceRow& row : job.rows) {
    if (job.options.part.is_whole()) break;
    const auto sequence = read_sequence(job.dataset, row);
    if (!sequence) return sequence.error();
    auto part = sequence_part(job.options.part, *sequence);
    if (!part) return part.error();
    if (!job.sees(ImageView::cartesian)) continue;
    const auto map = read_cartesian_map(job.dataset, *sequence);
    if (!map) return map.error();
    const auto cut = part_of_map(*part, *map, *sequence);
    if (!cut) return cut.error();
  }
  return {};
}

Rendered render_sequence(const Job& job, const StoredSequenceRow& row, const Workers& workers) {
  Rendered rendered;
  const auto sequence = read_sequence(job.dataset, row);
  if (!sequence) return {sequence.error(), {}, {}, {}};
  const auto shown = sequence_display(job.dataset, *sequence, job.display, job.options.part,
                                      job.sees(ImageView::cartesian));
  if (!shown) return {shown.error(), {}, {}, {}};
  rendered.part = shown->part;
  const auto pings = static_cast<std::size_t>(row.pings());
  const std::size_t views = job.views.size();
  std::vector<Status> statuses(pings);
  std::vector<DisplayCounts> counts(pings);
  rendered.files.resize(pings * views);
  workers.for_each(pings, [&](std::size_t i) {
    statuses[i] =
        render_ping(job, *sequence, *shown, row.first_ping + static_cast<std::uint32_t>(i),
                    std::span(rendered.files).subspan(i * views, views), counts[i]);
  });
  for (std::size_t i = 0; i < pings; ++i) {
    if (!statuses[i] && rendered.status) rendered.status = statuses[i];
    rendered.counts += counts[i];
  }
  return rendered;
}

// Whether the path, relative to a render's folder, is of a file that a render writes.
bool is_render_file(const std::string& path) {
  if (path == layout::kRenderJson) return true;
  constexpr std::string_view kStart = "sequences/", kEnds[] = {"_polar.png", "_cartesian.png",
                                                               "_polar.jpg", "_cartesian.jpg"};
  if (!path.starts_with(kStart)) return false;
  // A hidden temporary file of an interrupted write, next to its file.
  if (path.find("/.") != std::string::npos || path.starts_with(".")) return true;
  return std::any_of(std::begin(kEnds), std::end(kEnds),
                     [&](std::string_view end) { return path.ends_with(end); });
}

// Removes what an earlier render left in the folder.
Status clear_folder(const Job& job) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(job.folder, error))) return {};
  if (!fs::is_directory(fs::symlink_status(job.folder, error))) {
    return Error{ErrorKind::usage, job.folder.string() + ": already exists and is not a folder"};
  }
  const bool whole = listed_file_size(job.folder, layout::kRenderJson).has_value();
  if (whole && !job.options.overwrite) {
    return Error{ErrorKind::usage,
                 job.folder.string() + ": already exists; give another --name, or --overwrite"};
  }
  const auto files = files_below(job.folder);
  if (!files) return files.error();
  for (const std::string& file : *files) {
    if (!is_render_file(file)) {
      return Error{ErrorKind::usage,
                   (job.folder / file).string() + ": is not a file of a render; move it away"};
    }
  }
  // Removes the manifest first, so that the rest of an interrupted removal is not a render.
  if (whole && ::unlink((job.folder / layout::kRenderJson).c_str()) != 0 && errno != ENOENT) {
    return write_error(job.folder / layout::kRenderJson, errno);
  }
  for (const std::string& file : *files) {
    if (::unlink((job.folder / file).c_str()) != 0 && errno != ENOENT) {
      return write_error(job.folder / file, errno);
    }
  }
  return {};
}

Result<RenderReport> write_render(const Job& job, const Workers& workers) {
  const std::size_t count = job.rows.size();
  const auto lanes = std::min<std::size_t>(count, static_cast<std::size_t>(workers.threads()));
  const int within = std::max(1, workers.threads() / static_cast<int>(lanes));
  std::vector<Rendered> rendered(count);
  workers.for_each(count, [&](std::size_t i) {
    rendered[i] = render_sequence(job, job.rows[i], Workers(within));
  });
  RenderManifest manifest;
  RenderReport report{job.folder, count, 0, job.display, {}};
  std::vector<FileEntry> files;
  for (std::size_t i = 0; i < count; ++i) {
    if (!rendered[i].status) return rendered[i].status.error();
    report.counts += rendered[i].counts;
    report.pings += job.rows[i].pings();
    for (FileEntry& file : rendered[i].files) {
      manifest.bytes += file.bytes;
      files.push_back(std::move(file));
    }
    manifest.sequences.push_back({job.rows[i].sequence,
                                  job.rows[i].first_ping,
                                  job.rows[i].last_ping,
                                  job.rows[i].sha256,
                                  {},
                                  {}});
    if (const auto& part = rendered[i].part) {
      if (job.sees(ImageView::polar)) manifest.sequences.back().polar = part->polar;
      if (job.sees(ImageView::cartesian)) manifest.sequences.back().cartesian = part->cartesian;
    }
  }
  manifest.name = job.options.name;
  manifest.program_version = job.options.program_version;
  manifest.program_commit = job.options.program_commit;
  for (const ImageView view : job.views) manifest.views.emplace_back(view_name(view));
  manifest.display = job.display;
  manifest.counts = report.counts;
  manifest.part = job.options.part;
  manifest.jpeg_quality = job.options.jpeg_quality;
  const Status written =
      write_whole(job.folder / layout::kRenderJson, json_text(render_json(manifest, files)));
  if (!written) return written.error();
  return report;
}

Result<RenderReport> render(const RenderOptions& options) {
  if (const Status fit = check_options(options); !fit) return fit.error();
  auto dataset = open_dataset(options.dataset);
  if (!dataset) return dataset.error();
  auto rows = rows_of(options, *dataset);
  if (!rows) return rows.error();
  const auto first = read_sequence(*dataset, rows->front());
  if (!first) return first.error();
  auto views = views_of(options, *first);
  if (!views) return views.error();
  Job job{options,           std::move(*dataset), std::move(*rows),
          std::move(*views), options.display,     options.dataset / render_folder(options.name)};
  const auto limits_db = limits_of(job);
  if (!limits_db) return limits_db.error();
  job.display.limits_db = *limits_db;
  if (const Status fit = check_parts(job); !fit) return fit.error();
  if (const Status cleared = clear_folder(job); !cleared) return cleared.error();
  return write_render(job, Workers(options.threads));
}

}  // namespace

Result<RenderReport> render_dataset(const RenderOptions& options) {
  return without_exceptions("rendering " + options.dataset.string(),
                            [&] { return render(options); });
}

}  // namespace ensonify
