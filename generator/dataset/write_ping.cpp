#include "dataset/write_ping.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/stage_times.h"
#include "dataset/catalogue.h"
#include "dataset/echo_arrays.h"
#include "dataset/geometry_files.h"
#include "dataset/image_exr.h"
#include "dataset/layout.h"
#include "dataset/overwrite.h"
#include "dataset/packed.h"
#include "dataset/ping_record.h"
#include "formats/exr.h"
#include "formats/npy.h"
#include "formats/png.h"
#include "formats/sha256.h"

namespace ensonify {
namespace {

// One file: its path and how to encode it.
struct FileJob {
  std::string name_template;
  Stage stage;
  std::function<Result<std::string>()> encode;
};

Stage stage_of(FileCodec codec) {
  const bool is_exr = codec == FileCodec::exr || codec == FileCodec::group_exr ||
                      codec == FileCodec::series_exr || codec == FileCodec::front_exr ||
                      codec == FileCodec::camera_exr;
  if (is_exr) return Stage::encode_exr;
  if (codec == FileCodec::png) return Stage::encode_png;
  return codec == FileCodec::npy ? Stage::encode_npy : Stage::encode_other;
}

// Whether the cells of a row exist, with the size of its image.
bool fits(const CatalogueRow& row, const SequenceInfo& info, const PingResult& result) {
  const GridSizes sizes = sizes_of(info);
  const auto count = std::visit([](const auto& cells) { return cells.size(); }, row.cells(result));
  if (count == 0 || count != cell_count(row, sizes)) return false;
  const auto has_shape = [&](const auto& image) {
    return grid_shape(row, sizes) == NpyShape{static_cast<std::uint64_t>(image->rows),
                                              static_cast<std::uint64_t>(image->columns)};
  };
  if (!row.view) return true;
  const bool polar = row.view == ImageView::polar;
  return row.plane != nullptr ? has_shape(polar ? result.polar : result.cartesian)
                              : has_shape(polar ? result.polar_grey : result.cartesian_grey);
}

// The part of the result that does not match the sequence; empty if all does.
std::string misfit(const SequenceInfo& info, const PingResult& result) {
  const FileSelection selection = selection_of(info);
  for (const CatalogueRow& row : catalogue()) {
    if (!row.cells || !is_wanted(row, selection) || fits(row, info, result)) continue;
    return row.array.empty() ? row.file : row.array;
  }
  const auto beams = static_cast<std::size_t>(info.sonar.beam_count);
  if (info.output.scatterers && result.amplitudes.size() != result.scatterers.size()) {
    return "scatterers";
  }
  if (result.first_return_m.size() != beams) return "first_return_m";
  if (result.object_in_world.size() > info.instances.size()) return "object_in_world";
  if (result.ping < info.first_ping || result.ping >= info.last_ping) return "ping";
  return {};
}

ExrAttributes polar_attributes(const SequenceInfo& info) {
  ExrAttributes attributes{{{"axes", "rows: samples, nearest first; columns: beams, 0 first"},
                            {"beam_order", "beam 0 is to starboard; azimuth grows to port"}},
                           {{"first_beam_azimuth_rad", beam_azimuth_rad(info.sonar, 0)},
                            {"range_step_m", range_step_m(info.sonar, info.water)}}};
  if (info.sonar.azimuth_rad.empty()) {
    attributes.numbers.emplace_back("beam_spacing_rad", info.sonar.beam_spacing_rad);
  }
  if (info.recording) attributes.numbers.emplace_back("first_range_m", info.sonar.first_range_m);
  return attributes;
}

// Times of the samples and the carrier, which the phases refer to.
ExrAttributes series_attributes(const SequenceInfo& info) {
  ExrAttributes attributes = polar_attributes(info);
  attributes.numbers.insert(attributes.numbers.end(),
                            {{"sample_interval_s", info.record.sample_interval_s},
                             {"carrier_frequency_hz", info.sonar.frequency_hz}});
  return attributes;
}

ExrAttributes front_attributes(const SequenceInfo& info) {
  const Sonar& sonar = info.sonar;
  ExrAttributes attributes{
      {{"axes", "rows: elevations, lowest first; columns: azimuths, beam 0 first"},
       {"beam_order", "beam 0 is to starboard; azimuth grows to port"}},
      {{"first_azimuth_rad", ray_azimuths_rad(sonar).front()},
       {"first_elevation_rad", ray_elevations_rad(sonar).front()},
       {"elevation_step_rad", sonar.elevation_fan_rad / sonar.rays_elevation}}};
  if (sonar.azimuth_rad.empty()) {
    attributes.numbers.emplace_back("azimuth_step_rad",
                                    sonar.beam_spacing_rad / sonar.rays_azimuth);
  }
  return attributes;
}

ExrAttributes camera_attributes() {
  return {{{"axes", "rows: top first; columns: left first; distorted as the image is"},
           {"frame", "x to the right of the image, y down, z along the axis of view"}},
          {}};
}

ExrAttributes cartesian_attributes(const CartesianGrid& grid) {
  return {{{"axes", "the fan from above, boresight up, port left; nearest neighbor"},
           {"beam_order", "beam 0 is to starboard, on the right"}},
          {{"metres_per_pixel", grid.m_per_px},
           {"x_top_m", grid.x_top_m},
           {"y_left_m", grid.y_left_m}}};
}

// By instance id; none has id 0.
std::vector<std::uint8_t> class_of_instance(const SequenceInfo& info) {
  std::vector<std::uint8_t> classes{0};
  for (const Instance& instance : info.instances) classes.push_back(instance.class_id);
  return classes;
}

// [rows x columns x 3]
Result<std::string> encode_colors(std::span<const std::uint8_t> values, const NpyShape& shape) {
  std::vector<RgbPixel> pixels(values.size() / 3);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
  }
  return encode_png(std::span<const RgbPixel>(pixels), static_cast<int>(shape[0]),
                    static_cast<int>(shape[1]));
}

Result<std::string> encode_cells(const CatalogueRow& row, const SequenceInfo& info,
                                 const PingResult& result) {
  const NpyShape shape = grid_shape(row, sizes_of(info));
  return std::visit(
      [&](auto cells) -> Result<std::string> {
        using Value = std::remove_const_t<typename decltype(cells)::element_type>;
        if constexpr (std::is_same_v<Value, std::uint8_t>) {
          if (row.grid == FileGrid::camera_color) return encode_colors(cells, shape);
        }
        if constexpr (!std::is_integral_v<Value>) {
          return encode_npy(cells, shape);
        } else {
          return encode_png(cells, static_cast<int>(shape[0]), static_cast<int>(shape[1]));
        }
      },
      row.cells(result));
}

Result<std::string> encode_file(const CatalogueRow& row, const SequenceInfo& info,
                                const PingResult& result) {
  const bool is_polar = row.view == ImageView::polar;
  const auto encode = [&](auto encoder) {
    return is_polar ? encoder(*result.polar, polar_attributes(info))
                    : encoder(*result.cartesian, cartesian_attributes(*info.cartesian));
  };
  switch (row.codec) {
    case FileCodec::exr:
      return encode(encode_exr);
    case FileCodec::group_exr:
      return encode([&](const LabelledImage& image, const ExrAttributes& attributes) {
        return encode_group_exr(image, row.plane->group(), attributes);
      });
    case FileCodec::front_exr:
      return encode_front_exr(*result.front, front_attributes(info));
    case FileCodec::camera_exr:
      return encode_camera_exr(*result.camera, row.camera_plane->file, camera_attributes());
    case FileCodec::series_exr:
      return encode_series_exr(result.series, info.record.samples, info.sonar.beam_count,
                               series_attributes(info));
    case FileCodec::ply:
      return encode_points(result.scatterers, result.sonar_in_world,
                           source_pressure_pa_m(info.sonar), class_of_instance(info));
    default:
      if (row.grid != FileGrid::list) return encode_cells(row, info, result);
      if (row.type == kNpyElevation) return encode_elevation(result.elevation);
      if (row.type == kNpyVia) return encode_via(result.scatterers);
      return encode_scatterers(result.scatterers, result.amplitudes, result.sonar_in_world);
  }
}

// Files that take long to encode come first, so that no worker starts one after all others are
// done.
int encoding_rank(const CatalogueRow& row) {
  if (!plane_facts(row).name.empty()) return 0;
  if (row.grid == FileGrid::list) return 3;
  if (row.codec == FileCodec::series_exr) return 2;
  return row.codec == FileCodec::npy ? 1 : 4;
}

std::vector<FileJob> jobs_of(const SequenceInfo& info, const PingResult& result) {
  const FileSelection selection = selection_of(info);
  std::vector<const CatalogueRow*> rows;
  for (const CatalogueRow& row : catalogue()) {
    if (is_ping_file(row, selection)) rows.push_back(&row);
  }
  std::stable_sort(rows.begin(), rows.end(), [](const CatalogueRow* a, const CatalogueRow* b) {
    return encoding_rank(*a) < encoding_rank(*b);
  });
  std::vector<FileJob> jobs;
  if (info.output.packed) {
    jobs.push_back({layout::kPiece, Stage::encode_other,
                    [&]() -> Result<std::string> { return encode_piece(info, result); }});
  }
  for (const CatalogueRow* row : rows) {
    jobs.push_back({row->file, stage_of(row->codec),
                    [&info, &result, row] { return encode_file(*row, info, result); }});
  }
  return jobs;
}

Result<EncodedFile> do_job(std::uint32_t ping, const FileJob& job, const Workers& workers) {
  EncodedFile file;
  file.name_template = job.name_template;
  file.entry.path = layout::ping_file(job.name_template, ping);
  return without_exceptions("encoding " + file.entry.path, [&]() -> Result<EncodedFile> {
    Result<std::string> bytes = timed(workers, job.stage, job.encode);
    if (!bytes) return bytes.error();
    file.bytes = std::move(*bytes);
    file.entry.bytes = file.bytes.size();
    file.entry.sha256 = timed(workers, Stage::hash, [&] { return sha256_hex(file.bytes); });
    return std::move(file);
  });
}

Result<EncodedPing> encode_all(const SequenceInfo& info, const PingResult& result,
                               const Workers& workers) {
  const auto jobs = jobs_of(info, result);
  std::vector<std::optional<Result<EncodedFile>>> done(jobs.size());
  workers.for_each(jobs.size(),
                   [&](std::size_t i) { done[i] = do_job(result.ping, jobs[i], workers); });
  EncodedPing encoded;
  encoded.ping = result.ping;
  std::vector<FileEntry> entries;
  for (auto& file : done) {
    if (!file->ok()) return file->error();
    entries.push_back((*file)->entry);
    encoded.files.push_back(std::move(**file));
  }
  encoded.record = timed(workers, Stage::record,
                         [&] { return to_text(record_of(info, result, std::move(entries))); });
  return encoded;
}

Status store_all(const std::filesystem::path& dir, const SequenceInfo& info,
                 const EncodedPing& encoded) {
  std::vector<std::string> templates;
  for (const EncodedFile& file : encoded.files) templates.push_back(file.name_template);
  if (const auto planned = plan_sequence(dir, info, templates); !planned) return planned;
  for (const EncodedFile& file : encoded.files) {
    const std::string relative = layout::in_sequence(info.sequence, file.entry.path);
    if (Status written = write_hashed_file(dir, relative, file.bytes); !written) return written;
  }
  return write_hashed_file(dir, layout::record_path(info.sequence, encoded.ping), encoded.record);
}

}  // namespace

bool ping_is_finished(const std::filesystem::path& dir, std::uint32_t sequence, std::uint32_t ping,
                      const SequenceInfo& info) {
  if (ping < info.first_ping || ping >= info.last_ping) return false;
  if (listed_file_size(dir, layout::in_sequence(sequence, layout::kSequenceJson))) return true;
  const auto record = without_exceptions("reading a record",
                                         [&]() { return read_ping_record(dir, sequence, ping); });
  return record && files_are_there(dir, sequence, *record);
}

Result<EncodedPing> encode_ping(const SequenceInfo& info, const PingResult& result,
                                const Workers& workers) {
  if (const std::string what = misfit(info, result); !what.empty()) {
    return Error{ErrorKind::bug, fmt::format("sequence {}, ping {}: {} does not match the "
                                             "sequence; please report this",
                                             info.sequence, result.ping, what)};
  }
  return without_exceptions(
      fmt::format("encoding ping {} of sequence {}", result.ping, info.sequence),
      [&] { return encode_all(info, result, workers); });
}

Status store_ping(const std::filesystem::path& dir, const SequenceInfo& info,
                  const EncodedPing& encoded) {
  if (ping_is_finished(dir, info.sequence, encoded.ping, info)) return {};
  return without_exceptions(
      fmt::format("writing ping {} of sequence {}", encoded.ping, info.sequence),
      [&] { return store_all(dir, info, encoded); });
}

Status write_ping(const std::filesystem::path& dir, const SequenceInfo& info,
                  const PingResult& result, const Workers& workers) {
  const Result<EncodedPing> encoded = encode_ping(info, result, workers);
  return encoded ? store_ping(dir, info, *encoded) : Status(encoded.error());
}

}  // namespace ensonify
