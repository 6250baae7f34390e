#include "figure/figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "figure/animation.h"
#include "figure/drawing.h"
#include "figure/frames.h"
#include "formats/files.h"
#include "formats/output_place.h"

namespace ensonify {
namespace {

Result<std::string> encode_still(const FrameMaker& maker, const FigureJob& job) {
  const auto drawing = maker.frame(job.first_ping);
  if (!drawing) return drawing.error();
  if (job.format == FigureFormat::svg) return encode_svg(*drawing);
  const auto image = draw_raster(*drawing);
  return image ? encode_png(*image) : Result<std::string>(image.error());
}

Status animate(const FrameMaker& maker, const FigureJob& job, const FigureOptions& options,
               const std::filesystem::path& path) {
  const AnimationFormat format{maker.layout().width, maker.layout().height, maker.fps()};
  auto sink = job.format == FigureFormat::mp4 ? open_mp4(path, format) : open_webp(path, format);
  if (!sink) return sink.error();
  for (std::uint32_t ping = job.first_ping; ping < job.last_ping; ++ping) {
    if (options.stop != nullptr && options.stop()) {
      return Error{ErrorKind::interrupted, "interrupted; no files were left"};
    }
    const auto drawing = maker.frame(ping);
    if (!drawing) return drawing.error();
    const auto image = draw_raster(*drawing);
    if (!image) return image.error();
    if (const Status added = (*sink)->add(*image); !added) return added;
  }
  return (*sink)->finish();
}

constexpr int kMinWidth = 200, kMaxWidth = 8000;

Error usage(const std::string& what) { return {ErrorKind::usage, what}; }

bool is_level(FigureQuantity quantity) {
  return quantity == FigureQuantity::level || quantity == FigureQuantity::clean;
}

std::optional<FigureFormat> format_of(const std::filesystem::path& output) {
  constexpr std::pair<const char*, FigureFormat> kFormats[] = {{".png", FigureFormat::png},
                                                               {".svg", FigureFormat::svg},
                                                               {".webp", FigureFormat::webp},
                                                               {".mp4", FigureFormat::mp4}};
  std::string extension = output.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const auto& [name, format] : kFormats) {
    if (extension == name) return format;
  }
  return std::nullopt;
}

// Finds options that contradict each other for any data set.
Status check_options(const FigureOptions& o, FigureFormat format) {
  const bool animated = is_animated(format);
  if (animated && o.ping)
    return usage("--ping is for .png and .svg; an animation takes --pings A:B");
  if (!animated && o.pings)
    return usage("--pings is for .webp and .mp4; a still image takes --ping P");
  if (!animated && o.fps) return usage("--fps is for .webp and .mp4");
  if (o.fps && !(*o.fps >= 0.1 && *o.fps <= 60)) {
    return usage(fmt::format("--fps {}: expected 0.1 to 60 frames per second", *o.fps));
  }
  if (o.db && !is_level(o.quantity)) return usage("--db is for the quantities level and clean");
  if (o.db &&
      !(std::isfinite((*o.db)[0]) && std::isfinite((*o.db)[1]) && (*o.db)[0] < (*o.db)[1])) {
    return usage(fmt::format("--db {}:{}: the lower limit comes first; expected MIN:MAX in dB",
                             (*o.db)[0], (*o.db)[1]));
  }
  if (o.bilinear && !is_level(o.quantity)) {
    return usage("--interpolation bilinear is for the quantities level and clean");
  }
  if (is_mask(o.quantity) && !o.colour_map.empty()) {
    return usage("--color-map is for level, clean and elevation; masks have their own colors");
  }
  if (is_mask(o.quantity) && o.outlines) {
    return usage("--outlines is for level, clean and elevation; a mask shows the same outlines");
  }
  const bool by_instance =
      o.outlines || (is_mask(o.quantity) && o.quantity != FigureQuantity::semantic);
  if (!o.instances.empty() && !by_instance) {
    return usage("--instances needs --outlines, or --quantity instance, shadow or multipath");
  }
  if (o.width_px != 0 && (o.width_px < kMinWidth || o.width_px > kMaxWidth)) {
    return usage(fmt::format("--width-px {}: expected {} to {}", o.width_px, kMinWidth, kMaxWidth));
  }
  return {};
}

Result<StoredSequenceRow> row_of(const FigureOptions& o, const StoredDataset& dataset) {
  if (dataset.sequences.empty()) return usage(o.dataset.string() + ": has no sequences");
  if (!o.sequence) return dataset.sequences.front();
  for (const StoredSequenceRow& row : dataset.sequences) {
    if (row.sequence == *o.sequence) return row;
  }
  const std::uint32_t first = dataset.sequences.front().sequence;
  const std::uint32_t last = dataset.sequences.back().sequence;
  return usage(fmt::format("--sequence {}: {} has {}", *o.sequence, o.dataset.string(),
                           first == last ? fmt::format("only sequence {}", first)
                                         : fmt::format("sequences {} to {}", first, last)));
}

Status choose_pings(const FigureOptions& o, FigureJob& job) {
  const StoredSequenceRow& row = job.sequence.row;
  const auto there = fmt::format("sequence {} has pings {} to {}", row.sequence, row.first_ping,
                                 std::int64_t{row.last_ping} - 1);
  if (row.pings() == 0) return usage(fmt::format("sequence {} has no pings", row.sequence));
  job.first_ping = row.first_ping;
  job.last_ping = is_animated(job.format) ? row.last_ping : row.first_ping + 1;
  if (o.ping) {
    if (*o.ping < row.first_ping || *o.ping >= row.last_ping) {
      return usage(fmt::format("--ping {}: {}", *o.ping, there));
    }
    job.first_ping = *o.ping;
    job.last_ping = *o.ping + 1;
  }
  if (o.pings) {
    const auto [first, last] = *o.pings;
    if (first < row.first_ping || last > row.last_ping || first >= last) {
      return usage(
          fmt::format("--pings {}:{}: {}; expected A:B, the first ping and the one "
                      "after the last",
                      first, last, there));
    }
    job.first_ping = first;
    job.last_ping = last;
  }
  return {};
}

// Planes to read of each image; levels also need the expected levels and elevations for their
// limits.
Status choose_planes(const FigureOptions& o, FigureJob& job) {
  const PlaneNames there = stored_planes(job.sequence, ImageView::polar);
  if (!there.contains("level_db")) {
    return usage(
        fmt::format("{}: sequence {} has no polar images of its pings, which figures need; "
                    "generate the data set with `output.polar: true` and `output.pings: true`",
                    o.dataset.string(), job.sequence.row.sequence));
  }
  const std::string_view plane = plane_of(o.quantity);
  const bool labels = job.sequence.manifest.info.output.labels;
  if (!labels && (o.quantity != FigureQuantity::level || o.outlines)) {
    return usage(
        fmt::format("{}: a recording, which has levels and no labels; expected --quantity "
                    "level without --outlines",
                    o.dataset.string()));
  }
  if (!there.contains(plane)) {
    return usage(
        fmt::format("{}: its pings have no {} masks; generate the data set with "
                    "`output.{}: true`",
                    o.dataset.string(), plane, plane));
  }
  job.planes = {plane};
  if (labels && is_level(o.quantity)) job.planes.insert("clean_db");
  if (labels && !is_mask(o.quantity)) job.planes.insert("elevation_rad");
  if (o.outlines) job.planes.insert("instance");
  return {};
}

Status choose_instances(const FigureOptions& o, FigureJob& job) {
  const auto& all = job.sequence.instances;
  job.chosen.assign(all.size() + 1, o.instances.empty());
  for (const std::string& name : o.instances) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const StoredInstance& instance) {
      return instance.name == name;
    });
    if (found == all.end()) {
      std::string names;
      for (std::size_t i = 0; i < all.size() && i < 20; ++i) {
        names += fmt::format("{}{}", i > 0 ? ", " : "", all[i].name);
      }
      return usage(fmt::format("--instances {}: no such instance; expected one of {}{}", name,
                               names, all.size() > 20 ? ", ..." : ""));
    }
    job.chosen[found->id] = true;
  }
  return {};
}

}  // namespace

Result<FigureReport> write_figure(const FigureOptions& options) {
  return without_exceptions("drawing " + options.output.string(), [&]() -> Result<FigureReport> {
    const auto job = choose(options);
    if (!job) return job.error();
    auto place = OutputPlace::open(options.output, false, options.dataset, options.overwrite);
    if (!place) return place.error();
    const auto maker = FrameMaker::open(*job, options);
    if (!maker) return maker.error();
    Status written;
    if (is_animated(job->format)) {
      written = animate(*maker, *job, options, place->temporary());
    } else {
      const auto bytes = encode_still(*maker, *job);
      written = bytes ? write_whole(place->temporary(), *bytes) : Status(bytes.error());
    }
    if (written) written = place->commit();
    if (!written) return written.error();
    return FigureReport{job->last_ping - job->first_ping, maker->limits()};
  });
}

bool is_animated(FigureFormat format) {
  return format == FigureFormat::webp || format == FigureFormat::mp4;
}

std::string_view plane_of(FigureQuantity quantity) {
  constexpr std::string_view kPlanes[] = {"level_db", "clean_db", "elevation_rad", "instance",
                                          "semantic", "shadow",   "multipath"};
  return kPlanes[static_cast<std::size_t>(quantity)];
}

bool is_mask(FigureQuantity quantity) { return quantity >= FigureQuantity::instance; }

std::string colour_map_list() {
  std::string names;
  for (const ColourMap& map : colour_maps())
    names += (names.empty() ? "" : ", ") + std::string(map.name);
  return names;
}

Result<FigureJob> choose(const FigureOptions& o) {
  FigureJob job;
  const auto format = format_of(o.output);
  if (!format) {
    return usage(o.output.string() +
                 ": unknown format; expected a name that ends in .png, .svg, .webp or .mp4");
  }
  job.format = *format;
  if (const Status fits = check_options(o, *format); !fits) return fits.error();
  if (!is_mask(o.quantity)) {
    const char* own = o.quantity == FigureQuantity::elevation ? "viridis" : "inferno";
    job.map = find_colour_map(o.colour_map.empty() ? own : o.colour_map);
    if (job.map == nullptr) {
      return usage(
          fmt::format("--color-map {}: unknown; expected {}", o.colour_map, colour_map_list()));
    }
  }
  auto dataset = open_dataset(o.dataset);
  if (!dataset) return dataset.error();
  job.dataset = std::move(*dataset);
  const auto row = row_of(o, job.dataset);
  if (!row) return row.error();
  auto sequence = read_sequence(job.dataset, *row);
  if (!sequence) return sequence.error();
  job.sequence = std::move(*sequence);
  Status chosen = choose_pings(o, job);
  if (chosen) chosen = choose_planes(o, job);
  if (chosen) chosen = choose_instances(o, job);
  if (!chosen) return chosen.error();
  return job;
}

}  // namespace ensonify
