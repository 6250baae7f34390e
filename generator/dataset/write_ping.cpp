#include "dataset/write_ping.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dataset/exr.h"
#include "dataset/layout.h"
#include "dataset/npy.h"
#include "dataset/overwrite.h"
#include "dataset/packed.h"
#include "dataset/ping_record.h"
#include "dataset/ply.h"
#include "dataset/png.h"
#include "dataset/sha256.h"

namespace ensonify {
namespace {

// One file: where it goes and how its bytes come about.
struct FileJob {
  std::string name_template;
  std::function<Result<std::string>()> encode;
};

std::size_t area(int rows, int columns) {
  return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
}

bool fits(const std::optional<LabelledImage>& image, int rows, int columns,
          const OutputSelection& output) {
  if (!image || image->rows != rows || image->columns != columns || rows < 1 || columns < 1) {
    return false;
  }
  const std::size_t pixels = area(rows, columns);
  return image->level_db.size() == pixels && image->clean_db.size() == pixels &&
         image->elevation_rad.size() == pixels && image->elevation_std_rad.size() == pixels &&
         image->instance_fraction.size() == pixels && image->instance.size() == pixels &&
         image->semantic.size() == pixels && (!output.shadow || image->shadow.size() == pixels) &&
         (!output.multipath || image->multipath.size() == pixels);
}

bool fits(const std::optional<GreyImage>& image, int rows, int columns) {
  return !image || (rows > 0 && columns > 0 && image->rows == rows && image->columns == columns &&
                    image->pixels.size() == area(rows, columns));
}

bool fit(const std::vector<Layer>& asked, const std::vector<LayerSeries>& layers,
         std::size_t pixels) {
  return std::equal(asked.begin(), asked.end(), layers.begin(), layers.end(),
                    [&](Layer layer, const LayerSeries& series) {
                      return series.layer == layer && series.pressure_pa.size() == pixels;
                    });
}

// What of the result does not fit the sequence; empty if all does.
std::string misfit(const SequenceInfo& info, const PingResult& result) {
  const int beams = info.sonar.beam_count;
  const int samples = info.record.samples;
  const CartesianGrid grid = info.cartesian.value_or(CartesianGrid{});
  const auto is_bad = [](bool asked, bool fitting) { return asked && !fitting; };
  if (is_bad(info.output.any_timeseries(), result.series.size() == area(beams, samples))) {
    return "series";
  }
  if (is_bad(info.output.polar, fits(result.polar, samples, beams, info.output))) return "polar";
  if (is_bad(info.output.cartesian,
             fits(result.cartesian, grid.height_px, grid.width_px, info.output))) {
    return "cartesian";
  }
  if (!fits(result.polar_grey, samples, beams)) return "polar_grey";
  if (!fits(result.cartesian_grey, grid.height_px, grid.width_px)) return "cartesian_grey";
  if (is_bad(info.output.png, result.polar_grey || result.cartesian_grey)) return "png";
  const bool all_grey = result.polar_grey && (result.cartesian_grey || !info.output.cartesian);
  if (is_bad(info.output.png && info.output.packed, all_grey)) return "png";
  if (is_bad(info.output.scatterers, result.amplitudes.size() == result.scatterers.size())) {
    return "scatterers";
  }
  if (is_bad(info.output.channels,
             result.channels.size() == info.element_y_m.size() * info.record.samples)) {
    return "channels";
  }
  if (!fit(info.layers, result.layers, area(beams, samples))) return "layers";
  if (result.first_return_m.size() != static_cast<std::size_t>(beams)) return "first_return_m";
  if (result.object_in_world.size() > info.instances.size()) return "object_in_world";
  if (result.ping < info.first_ping || result.ping >= info.last_ping) return "ping";
  return {};
}

ExrAttributes polar_attributes(const SequenceInfo& info) {
  return {{{"axes", "rows: samples, nearest first; columns: beams, 0 first"},
           {"beam_order", "beam 0 is to starboard, azimuth grows to port"}},
          {{"first_beam_azimuth_rad", beam_azimuth_rad(info.sonar, 0)},
           {"beam_spacing_rad", info.sonar.beam_spacing_rad},
           {"range_step_m", sample_range_m(info.sonar, info.water, 1)}}};
}

// Times of the samples and the carrier, which the phases refer to.
ExrAttributes series_attributes(const SequenceInfo& info) {
  ExrAttributes attributes = polar_attributes(info);
  attributes.numbers.insert(attributes.numbers.end(),
                            {{"sample_interval_s", info.record.sample_interval_s},
                             {"carrier_frequency_hz", info.sonar.frequency_hz}});
  return attributes;
}

ExrAttributes cartesian_attributes(const CartesianGrid& grid) {
  return {{{"axes", "the fan from above, boresight up, port left; nearest neighbour"},
           {"beam_order", "beam 0 is to starboard, on the right"}},
          {{"metres_per_pixel", grid.m_per_px},
           {"x_top_m", grid.x_top_m},
           {"y_left_m", grid.y_left_m}}};
}

// Names of the files of one picture; no shadow or multipath: not asked for.
struct ImageNames {
  const char *exr, *instance, *semantic, *shadow, *multipath;
};

void add_image_jobs(std::vector<FileJob>& jobs, const LabelledImage& image,
                    const ExrAttributes& attributes, const ImageNames& names) {
  jobs.push_back({names.exr, [&image, attributes] { return encode_exr(image, attributes); }});
  const auto add_ids = [&](const char* name, const std::vector<std::uint16_t>& ids) {
    if (name == nullptr) return;
    jobs.push_back({name, [&image, &ids] {
                      return encode_png(ids, image.rows, image.columns, Content::runs);
                    }});
  };
  add_ids(names.instance, image.instance);
  jobs.push_back({names.semantic, [&image] {
                    return encode_png(image.semantic, image.rows, image.columns, Content::runs);
                  }});
  add_ids(names.shadow, image.shadow);
  add_ids(names.multipath, image.multipath);
}

void add_grey_job(std::vector<FileJob>& jobs, const std::optional<GreyImage>& grey,
                  const char* name) {
  if (!grey) return;
  jobs.push_back({name, [&image = *grey] {
                    return encode_png(image.pixels, image.rows, image.columns, Content::noise);
                  }});
}

// By instance id; none has id 0.
std::vector<std::uint8_t> class_of_instance(const SequenceInfo& info) {
  std::vector<std::uint8_t> classes{0};
  for (const Instance& instance : info.instances) classes.push_back(instance.class_id);
  return classes;
}

// What stays one file a ping in packed sequences too: their lengths differ.
void add_list_jobs(std::vector<FileJob>& jobs, const SequenceInfo& info, const PingResult& result) {
  if (info.output.scatterers) {
    jobs.push_back({layout::kScatterers, [&result]() -> Result<std::string> {
                      return encode_scatterers(result.scatterers, result.amplitudes,
                                               result.sonar_in_world);
                    }});
  }
  if (info.output.points) {
    jobs.push_back({layout::kPoints, [&]() -> Result<std::string> {
                      return encode_points(result.scatterers, result.sonar_in_world,
                                           source_pressure_pa_m(info.sonar),
                                           class_of_instance(info));
                    }});
  }
}

// Long jobs first, so that no worker starts one when the others are done.
std::vector<FileJob> jobs_of(const SequenceInfo& info, const PingResult& result) {
  using namespace layout;
  std::vector<FileJob> jobs;
  if (info.output.packed) {
    jobs.push_back({kPiece, [&]() -> Result<std::string> { return encode_piece(info, result); }});
    add_list_jobs(jobs, info, result);
    return jobs;
  }
  if (info.output.polar) {
    add_image_jobs(
        jobs, *result.polar, polar_attributes(info),
        {kPolarExr, kPolarInstance, kPolarSemantic, info.output.shadow ? kPolarShadow : nullptr,
         info.output.multipath ? kPolarMultipath : nullptr});
  }
  if (info.output.cartesian) {
    add_image_jobs(jobs, *result.cartesian, cartesian_attributes(*info.cartesian),
                   {kCartesianExr, kCartesianInstance, kCartesianSemantic,
                    info.output.shadow ? kCartesianShadow : nullptr,
                    info.output.multipath ? kCartesianMultipath : nullptr});
  }
  const auto add_series = [&](std::string name, const std::vector<std::complex<float>>& series) {
    const auto samples = static_cast<std::uint64_t>(info.record.samples);
    jobs.push_back({std::move(name), [&series, samples]() -> Result<std::string> {
                      return encode_npy(series, {series.size() / samples, samples});
                    }});
  };
  if (info.output.timeseries) add_series(kTimeseries, result.series);
  if (info.output.channels) add_series(kChannels, result.channels);
  for (const LayerSeries& layer : result.layers) {
    add_series(layer_template(layer_name(layer.layer)), layer.pressure_pa);
  }
  if (info.output.timeseries_exr) {
    jobs.push_back({kTimeseriesExr, [&] {
                      return encode_series_exr(result.series, info.record.samples,
                                               info.sonar.beam_count, series_attributes(info));
                    }});
  }
  add_list_jobs(jobs, info, result);
  if (info.output.png) {
    add_grey_job(jobs, result.polar_grey, kPolarGrey);
    add_grey_job(jobs, result.cartesian_grey, kCartesianGrey);
  }
  return jobs;
}

Result<EncodedFile> do_job(std::uint32_t ping, const FileJob& job) {
  EncodedFile file;
  file.name_template = job.name_template;
  file.entry.path = layout::ping_file(job.name_template, ping);
  return without_exceptions("encoding " + file.entry.path, [&]() -> Result<EncodedFile> {
    Result<std::string> bytes = job.encode();
    if (!bytes) return bytes.error();
    file.bytes = std::move(*bytes);
    file.entry.bytes = file.bytes.size();
    file.entry.sha256 = sha256_hex(file.bytes);
    return std::move(file);
  });
}

Result<EncodedPing> encode_all(const SequenceInfo& info, const PingResult& result,
                               const Workers& workers) {
  const auto jobs = jobs_of(info, result);
  std::vector<std::optional<Result<EncodedFile>>> done(jobs.size());
  workers.for_each(jobs.size(), [&](std::size_t i) { done[i] = do_job(result.ping, jobs[i]); });
  EncodedPing encoded;
  encoded.ping = result.ping;
  std::vector<FileEntry> entries;
  for (auto& file : done) {
    if (!file->ok()) return file->error();
    entries.push_back((*file)->entry);
    encoded.files.push_back(std::move(**file));
  }
  encoded.record = to_line(record_of(info, result, std::move(entries)));
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
    return Error{ErrorKind::bug, fmt::format("sequence {}, ping {}: {} does not fit what the "
                                             "sequence says of it; please report this",
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
