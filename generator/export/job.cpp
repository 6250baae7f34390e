#include "export/job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dataset/layout.h"
#include "formats/files.h"
#include "formats/jpeg.h"
#include "formats/json.h"
#include "formats/png.h"

namespace ensonify {
namespace {

Status for_each_of_dataset(const ExportJob& job,
                           const std::function<Status(const StoredSequence&)>& use) {
  for (const StoredSequenceRow& row : job.dataset.sequences) {
    const auto sequence = read_sequence(job.dataset, row);
    if (!sequence) return sequence.error();
    if (sequence->packed) {
      return Error{ErrorKind::usage,
                   job.dataset.dir.string() +
                       ": its pings are packed into arrays of each sequence; expected a data "
                       "set with output.one_file_per: ping"};
    }
    if (const Status used = use(*sequence); !used) return used;
  }
  return {};
}

}  // namespace

Status for_each_sequence(const ExportJob& job,
                         const std::function<Status(const StoredSequence&)>& use) {
  if (job.sweep == nullptr) return for_each_of_dataset(job, use);
  for (const PlannedRun& run : job.sweep->runs) {
    if (const Status opened = job.sweep->open(run); !opened) return opened;
    if (const Status used = for_each_of_dataset(job, use); !used) return used;
  }
  return {};
}

Json run_members(const ExportJob& job) {
  if (job.sweep == nullptr) return Json::object();
  Json axes = Json::object();
  for (const auto& [axis, value] : job.sweep->current->values) axes[axis] = parse_shallow(value);
  return {{"run", job.sweep->current->id}, {"axes", std::move(axes)}};
}

Status for_each_exported_ping(const ExportJob& job, const StoredSequence& sequence,
                              const std::function<Status(const StoredPing&)>& use) {
  return for_each_ping(job.dataset, sequence, [&](const StoredPing& ping) -> Status {
    if (job.options.stop && job.options.stop()) {
      return Error{ErrorKind::interrupted, "interrupted; no files were left"};
    }
    return use(ping);
  });
}

Result<std::uint64_t> ping_ns(const StoredSequence& sequence, const StoredPing& ping) {
  constexpr double kMostSeconds = 2147483647;  // of ROS
  if (ping.time_s >= 0 && ping.time_s < kMostSeconds) {
    return static_cast<std::uint64_t>(std::llround(ping.time_s * 1e9));
  }
  return Error{ErrorKind::usage,
               fmt::format("sequence {}, ping {}: its time is {} s; this format needs 0 to "
                           "2147483647 s: shift the trajectory's times, or use another format",
                           sequence.row.sequence, ping.ping, ping.time_s)};
}

std::string item_name(const ExportJob& job, const StoredSequence& sequence,
                      const StoredPing& ping) {
  const std::string run = job.sweep != nullptr ? job.sweep->current->id + "_" : "";
  return fmt::format("{}{:06}_{:06}", run, sequence.row.sequence, ping.ping);
}

Status need(const ExportJob& job, const StoredSequence& sequence, const CatalogueRow& row) {
  if (is_rendered(job, row) || sequence.has(row)) return {};
  return Error{
      ErrorKind::usage,
      fmt::format(
          "{}: its pings have no {}, which this format needs; generate the data set with {}",
          (job.dataset.dir / layout::sequence_folder(sequence.row.sequence)).string(), row.file,
          row.maker)};
}

Result<std::filesystem::path> path_of(const ExportJob& job, const StoredSequence& sequence,
                                      const StoredPing& ping, const CatalogueRow& row) {
  if (!is_rendered(job, row)) {
    return ping_file(job.dataset, sequence.row.sequence, row.file, ping.ping);
  }
  const std::string relative =
      render_folder(job.render->name) + "/" +
      render_file(*row.view, sequence.row.sequence, ping.ping, job.render->jpeg_quality > 0);
  if (!listed_file_size(job.dataset.dir, relative)) {
    return damaged(job.dataset.dir / relative, "is missing, or is not a file of this folder");
  }
  return job.dataset.dir / relative;
}

Result<std::vector<std::uint8_t>> grey_pixels(const ExportJob& job,
                                              const std::filesystem::path& path, std::uint64_t rows,
                                              std::uint64_t columns) {
  if (!job.render || job.render->jpeg_quality == 0) return read_grey8(path, rows, columns);
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  auto jpeg = parse_grey_jpeg(*bytes, JpegSize{rows, columns});
  if (!jpeg) return damaged(path, jpeg.error().message);
  return std::move(jpeg->grey);
}

bool is_rendered(const ExportJob& job, const CatalogueRow& row) {
  return job.render && row.view && &row == &grey_row(*row.view);
}

std::string plain_name(std::string_view text, std::size_t most) {
  // Not within the bytes of a character.
  const auto continues = [&](std::size_t at) {
    return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U;
  };
  std::size_t end = std::min(most, text.size());
  while (end > 0 && end < text.size() && continues(end)) --end;
  std::string name;
  for (const char c : text.substr(0, end)) {
    const bool is_ascii = static_cast<unsigned char>(c) < 0x80;
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '_' || c == '.' || !is_ascii;
    name += plain ? c : '_';
  }
  return name;
}

// Bit j of the index goes to bit 7 - j / 3 of channel j mod 3.
Palette voc_palette() {
  Palette palette{};
  for (unsigned i = 0; i < 256; ++i) {
    for (unsigned j = 0; j < 8; ++j) {
      auto& channel = palette[i][j % 3];
      channel = static_cast<std::uint8_t>(channel | (i >> j & 1) << (7 - j / 3));
    }
  }
  return palette;
}

std::vector<std::string> splits_of(const ExportJob& job) {
  if (job.options.split) return {*job.options.split};
  return {layout::kSplits.begin(), layout::kSplits.end()};
}

const CatalogueRow& grey_of(const ExportJob& job) { return grey_row(job.view()); }
const CatalogueRow& mask_of_view(const ExportJob& job, std::string_view plane) {
  return plane_row(job.view(), plane);
}

namespace {

// Classes by class id - 1. Error (usage): one of the names is not a class.
Result<std::vector<bool>> classes_of(const StoredDataset& dataset, std::string_view option,
                                     const std::vector<std::string>& names) {
  std::vector<bool> found(dataset.classes.size());
  for (const std::string& name : names) {
    const auto at = std::find(dataset.classes.begin(), dataset.classes.end(), name);
    if (at == dataset.classes.end()) {
      std::string known;
      for (const std::string& of : dataset.classes) known += (known.empty() ? "" : ", ") + of;
      return Error{ErrorKind::usage, fmt::format("{}: the data set has no class {}; expected {}",
                                                 option, quoted_text(name), known)};
    }
    found[static_cast<std::size_t>(at - dataset.classes.begin())] = true;
  }
  return found;
}

std::uint64_t pixels_of(const StoredAnnotation& annotation) {
  std::int64_t pixels = 0;
  for (std::size_t i = 1; i < annotation.runs.size(); i += 2) pixels += annotation.runs[i];
  return static_cast<std::uint64_t>(pixels);
}

Result<bool> is_wanted(const ObjectFilter& filter, const StoredSequence& sequence,
                       const StoredAnnotation& annotation) {
  const std::uint64_t pixels = pixels_of(annotation);
  const std::uint8_t class_id = sequence.instances[annotation.instance - 1U].class_id;
  if (!filter.classes[class_id - 1U] || pixels < filter.min_pixels) return false;
  if (filter.min_visible <= 0) return true;
  if (!annotation.amodal_area) {
    return Error{ErrorKind::usage,
                 fmt::format("--min-visible: sequence {} has no amodal masks to compare with; "
                             "generate the data set with output.amodal: true",
                             sequence.row.sequence)};
  }
  const auto amodal = static_cast<double>(*annotation.amodal_area);
  return static_cast<double>(pixels) >= filter.min_visible * amodal;
}

}  // namespace

Result<ObjectFilter> object_filter(const StoredDataset& dataset, const ExportOptions& options) {
  ObjectFilter filter{{}, options.min_pixels.value_or(1), options.min_visible.value_or(0)};
  for (const ClassKind kind : dataset.class_kinds) {
    filter.classes.push_back(kind == ClassKind::thing);
  }
  if (options.classes) {
    auto chosen = classes_of(dataset, "--classes", *options.classes);
    if (!chosen) return chosen.error();
    filter.classes = std::move(*chosen);
  }
  const auto excluded = classes_of(dataset, "--exclude", options.exclude);
  if (!excluded) return excluded.error();
  for (std::size_t k = 0; k < filter.classes.size(); ++k) {
    if ((*excluded)[k]) filter.classes[k] = false;
  }
  return filter;
}

Result<StoredPicture> picture_of_view(const ExportJob& job, const StoredSequence& sequence,
                                      const StoredPing& ping, PictureView view) {
  auto pictures = pictures_of(job.dataset, sequence, ping);
  if (!pictures) return pictures.error();
  for (StoredPicture& picture : *pictures) {
    if (picture.view != view_name(view)) continue;
    std::vector<StoredAnnotation> wanted;
    for (StoredAnnotation& annotation : picture.annotations) {
      const auto is_in = is_wanted(job.objects, sequence, annotation);
      if (!is_in) return is_in.error();
      if (*is_in) wanted.push_back(std::move(annotation));
    }
    picture.annotations = std::move(wanted);
    return std::move(picture);
  }
  return damaged(job.dataset.dir / layout::in_sequence(sequence.row.sequence, layout::kAnnotations),
                 fmt::format("has no {} image of ping {}", view_name(view), ping.ping));
}

}  // namespace ensonify
