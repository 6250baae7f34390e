#include "figure/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/units.h"
#include "dataset/layout.h"
#include "formats/npy.h"
#include "labels/display.h"

namespace ensonify {
namespace {

constexpr int kStillWidth = 1200, kAnimatedWidth = 800;

// An axis of the data set: even steps upwards.
struct Axis {
  double first = 0, step = 0;
};

Result<Axis> read_axis(const FigureJob& job, const std::string& file, std::uint64_t count,
                       double step_of_one) {
  const auto path = stored_file(job.dataset, job.sequence.row.sequence, file);
  if (!path) return path.error();
  const auto array = read_npy(*path, kNpyFloat64, {count});
  if (!array) return array.error();
  double first = 0, last = 0;
  std::memcpy(&first, array->data().data(), sizeof first);
  std::memcpy(&last, array->data().data() + (count - 1) * sizeof last, sizeof last);
  const Axis axis{first, count > 1 ? (last - first) / static_cast<double>(count - 1) : step_of_one};
  if (!std::isfinite(first) || !std::isfinite(axis.step) || axis.step <= 0) {
    return damaged(*path, "does not increase");
  }
  return axis;
}

// Limits from the 1st to the 99th percentile, in whole degrees.
std::array<double, 2> degree_limits(std::span<const float> values_deg) {
  std::vector<float> known;
  for (const float value : values_deg) {
    if (!std::isnan(value)) known.push_back(value);
  }
  if (known.empty()) return {-10, 10};
  std::sort(known.begin(), known.end());
  const auto at = [&](double share) {
    return known[static_cast<std::size_t>(share * static_cast<double>(known.size() - 1))];
  };
  const double low = std::floor(at(0.01)), high = std::ceil(at(0.99));
  return high - low < 2 ? std::array{low - 1, high + 1} : std::array{low, high};
}

std::vector<float> in_degrees(std::span<const float> values_rad) {
  std::vector<float> values;
  for (const float value : values_rad) values.push_back(static_cast<float>(degrees(value)));
  return values;
}

std::vector<std::uint16_t> only(std::span<const std::uint16_t> ids,
                                const std::vector<bool>& chosen) {
  std::vector<std::uint16_t> kept;
  for (const std::uint16_t id : ids) {
    kept.push_back(id < chosen.size() && chosen[id] ? id : std::uint16_t{0});
  }
  return kept;
}

}  // namespace

Status FrameMaker::read_axes() {
  const StoredSequence& s = job_.sequence;
  const auto azimuth =
      read_axis(job_, "azimuth_rad.npy", s.beams, std::max(s.beam_width_rad, 1e-3));
  if (!azimuth) return azimuth.error();
  const auto range = read_axis(job_, "range_m.npy", s.samples, 1);
  if (!range) return range.error();
  around_.fan = {azimuth->first,
                 azimuth->step,
                 range->first,
                 range->step,
                 s.beams,
                 s.samples,
                 s.manifest.info.sonar.azimuth_rad};
  return {};
}

Status FrameMaker::read_times() {
  const Status read = for_each_ping(job_.dataset, job_.sequence, [&](const StoredPing& ping) {
    if (ping.ping >= job_.first_ping) times_s_.push_back(ping.time_s);
    // An end before the last ping.
    return ping.ping + 1 < job_.last_ping ? Status() : Status(Error{ErrorKind::interrupted, ""});
  });
  if (!read && read.error().kind != ErrorKind::interrupted) return read;
  return {};
}

void FrameMaker::set_scale(const StoredPixels& first) {
  if (is_mask(options_.quantity)) return;
  ColourBar bar;
  bar.map = job_.map;
  if (options_.quantity == FigureQuantity::elevation) {
    bar.label = "elevation (\xc2\xb0)";
    bar.limits = degree_limits(in_degrees(first.elevation_rad));
  } else {
    const SequenceInfo& info = job_.sequence.manifest.info;
    bar.label = options_.quantity == FigureQuantity::level ? "level" : "expected level";
    bar.label += info.recording ? " (dB)" : " (dB re 1 \xc2\xb5Pa)";
    if (info.output.labels) {
      bar.limits = options_.db.value_or(
          db_limits_from_clean(first.clean_db, first.elevation_rad, info.noise_power_pa2));
    } else {
      bar.limits = options_.db.value_or(db_limits_from_levels(first.level_db));
    }
  }
  around_.bar = bar;
}

// An outline of the seabed or of the tank would cover objects in front of it.
void FrameMaker::leave_out_wide(const StoredPixels& first) {
  if (!options_.outlines || !options_.instances.empty()) return;
  std::vector<std::uint64_t> beams(drawn_.size(), 0), last_beam(drawn_.size(), 0);
  for (std::uint64_t beam = 0; beam < first.columns; ++beam) {
    for (std::uint64_t i = beam; i < first.instance.size(); i += first.columns) {
      const std::uint16_t id = first.instance[i];
      if (id >= drawn_.size() || last_beam[id] == beam + 1) continue;
      last_beam[id] = beam + 1;
      ++beams[id];
    }
  }
  for (std::size_t id = 0; id < drawn_.size(); ++id) {
    if (2 * beams[id] > first.columns) drawn_[id] = false;
  }
}

// A still image lists the instances in it, and an animation all possible ones.
void FrameMaker::set_legend(const StoredPixels& first) {
  const bool animated = is_animated(job_.format);
  const auto add = [&](const auto& ids, std::size_t id, const std::string& name) {
    const bool seen = animated || std::find(ids.begin(), ids.end(), id) != ids.end();
    if (seen) {
      around_.legend.push_back({id_colour(static_cast<std::uint32_t>(id)), name});
    }
  };
  if (is_mask(options_.quantity)) {
    around_.legend.push_back(
        {kNoIdColour, options_.quantity == FigureQuantity::shadow ? "no shadow" : "none"});
  }
  if (options_.quantity == FigureQuantity::semantic) {
    for (std::size_t k = 0; k < job_.dataset.classes.size(); ++k) {
      add(first.semantic, k + 1, job_.dataset.classes[k]);
    }
    return;
  }
  if (!is_mask(options_.quantity) && !options_.outlines) return;
  const bool shadow = options_.quantity == FigureQuantity::shadow;
  const bool ghosts = options_.quantity == FigureQuantity::multipath;
  for (const StoredInstance& instance : job_.sequence.instances) {
    if (!drawn_[instance.id]) continue;
    add(shadow   ? first.shadow
        : ghosts ? first.multipath
                 : first.instance,
        instance.id,
        (shadow   ? "behind "
         : ghosts ? "mirrored "
                  : "") +
            instance.name);
  }
}

Result<FrameMaker> FrameMaker::open(const FigureJob& job, const FigureOptions& options) {
  FrameMaker maker(job, options);
  Status read = maker.read_axes();
  if (read) read = maker.read_times();
  if (!read) return read.error();
  const auto first = maker.pixels_of(job.first_ping);
  if (!first) return first.error();
  const bool cartesian = options.view == FigureView::cartesian;
  Surroundings& around = maker.around_;
  around.view = cartesian ? StoredView::cartesian : StoredView::polar;
  around.has_title = !options.title || !options.title->empty();
  maker.set_scale(*first);
  maker.leave_out_wide(*first);
  maker.set_legend(*first);
  const int width = is_animated(job.format) ? kAnimatedWidth : kStillWidth;
  maker.layout_ = layout_of(around, options.width_px > 0 ? options.width_px : width);
  const Layout& l = maker.layout_;
  maker.cells_ = cartesian
                     ? cartesian_cells(around.fan, l.extent, l.picture_width, l.picture_height)
                     : polar_cells(around.fan, l.picture_width, l.picture_height);
  return maker;
}

std::optional<std::array<double, 2>> FrameMaker::limits() const {
  return around_.bar ? std::optional(around_.bar->limits) : std::nullopt;
}

double FrameMaker::fps() const {
  if (options_.fps) return *options_.fps;
  const double time_s = times_s_.empty() ? 0 : times_s_.back() - times_s_.front();
  if (!(time_s > 0)) return 5;
  return std::clamp(static_cast<double>(times_s_.size() - 1) / time_s, 1.0, 30.0);
}

Result<StoredPixels> FrameMaker::pixels_of(std::uint32_t ping) const {
  return read_picture(job_.dataset, job_.sequence, ImageView::polar, ping, job_.planes);
}

RgbImage FrameMaker::paint(const StoredPixels& pixels) const {
  const int width = layout_.picture_width, height = layout_.picture_height;
  const auto mask = [&](std::span<const std::uint16_t> ids) {
    return paint_ids(cells_, width, height, ids, pixels.columns);
  };
  if (options_.quantity == FigureQuantity::semantic) {
    return mask(std::vector<std::uint16_t>(pixels.semantic.begin(), pixels.semantic.end()));
  }
  if (options_.quantity == FigureQuantity::instance) return mask(only(pixels.instance, drawn_));
  if (options_.quantity == FigureQuantity::shadow) return mask(only(pixels.shadow, drawn_));
  if (options_.quantity == FigureQuantity::multipath) return mask(only(pixels.multipath, drawn_));
  const std::vector<float> values = options_.quantity == FigureQuantity::level ? pixels.level_db
                                    : options_.quantity == FigureQuantity::clean
                                        ? pixels.clean_db
                                        : in_degrees(pixels.elevation_rad);
  const ValueScale scale{job_.map, around_.bar->limits, kNoIdColour};
  RgbImage image = paint_values(cells_, width, height, values, pixels.columns, scale,
                                options_.bilinear ? Sampling::bilinear : Sampling::nearest);
  if (options_.outlines) {
    outline(image, cells_, only(pixels.instance, drawn_), pixels.columns,
            std::max(1, layout_.width / 450));
  }
  return image;
}

std::string FrameMaker::title_of(std::uint32_t ping) const {
  if (options_.title) return *options_.title;
  std::string title = job_.dataset.name;
  if (job_.dataset.sequences.size() > 1) {
    title += fmt::format(", sequence {}", job_.sequence.row.sequence);
  }
  title += fmt::format(", ping {}", ping);
  const std::size_t place = ping - job_.first_ping;
  if (place < times_s_.size()) title += fmt::format(", {:.2f} s", times_s_[place]);
  return title;
}

Result<Drawing> FrameMaker::frame(std::uint32_t ping) const {
  const auto pixels = pixels_of(ping);
  if (!pixels) return pixels.error();
  return compose(layout_, around_, paint(*pixels), title_of(ping));
}

}  // namespace ensonify
