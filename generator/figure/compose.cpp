#include "figure/compose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace ensonify {
namespace {

constexpr Rgb8 kInk{0x22, 0x22, 0x22};
// Width of a sans-serif letter relative to the text size; a bit too wide, so that nothing overlaps.
constexpr double kLetter = 0.6;
constexpr double kLegendSize = 0.9, kLegendRow = 1.35, kSwatch = 0.85;
// Spokes are drawn only if the fan is wide enough.
constexpr double kMinSpokedFan = 20;

std::size_t letters(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  }));
}

// At most `most` letters, with an ellipsis at the end if the text is longer.
std::string cut(const std::string& text, std::size_t most) {
  if (letters(text) <= most) return text;
  std::size_t end = 0;
  for (std::size_t n = 0; end < text.size(); ++end) {
    if ((static_cast<unsigned char>(text[end]) & 0xc0) != 0x80 && n++ + 1 >= most) break;
  }
  return text.substr(0, end) + "\xe2\x80\xa6";
}

double legend_text_width(const std::vector<LegendEntry>& legend, double em) {
  std::size_t longest = 3;
  for (const LegendEntry& entry : legend) longest = std::max(longest, letters(entry.name));
  return static_cast<double>(std::min<std::size_t>(longest, 28)) * kLetter * kLegendSize * em;
}

int even(double value) { return 2 * static_cast<int>(std::lround(value / 2)); }

class Composer {
 public:
  Composer(const Layout& layout, const Surroundings& around) : l_(layout), around_(around) {
    drawing_.width = l_.width;
    drawing_.height = l_.height;
  }

  Drawing compose(RgbImage image, const std::string& title) {
    drawing_.items.emplace_back(DrawnPicture{l_.left, l_.top, std::move(image)});
    if (around_.view == StoredView::cartesian) {
      draw_rings();
      draw_spokes();
      draw_fan_edge();
    }
    draw_axes();
    if (around_.bar) draw_bar(*around_.bar);
    draw_legend();
    draw_title(title);
    return std::move(drawing_);
  }

 private:
  double right() const { return l_.left + l_.picture_width; }
  double bottom() const { return l_.top + l_.picture_height; }
  double hair() const { return std::max(1.0, l_.em / 18); }

  // The position of an axis value in the figure.
  double x_of(double value) const {
    const Extent& e = l_.extent;
    return l_.left + (value - e.left) / (e.right - e.left) * l_.picture_width;
  }
  double y_of(double value) const {
    const Extent& e = l_.extent;
    return l_.top + (value - e.top) / (e.bottom - e.top) * l_.picture_height;
  }
  PlotPoint at(double range_m, double azimuth_rad) const {
    return {x_of(range_m * std::sin(azimuth_rad)), y_of(range_m * std::cos(azimuth_rad))};
  }

  void line(std::vector<PlotPoint> points, Rgb8 colour, double width, double opacity = 1) {
    drawing_.items.emplace_back(DrawnLine{std::move(points), colour, width, opacity});
  }
  void text(double x, double y, std::string words, double size, Anchor anchor,
            bool upwards = false) {
    drawing_.items.emplace_back(DrawnText{x, y, std::move(words), size, anchor, upwards, kInk});
  }

  std::vector<PlotPoint> arc(double range_m) const {
    const double low = around_.fan.min_azimuth_rad(), high = around_.fan.max_azimuth_rad();
    const int steps = std::max(8, static_cast<int>(std::ceil(degrees(high - low))));
    std::vector<PlotPoint> points;
    for (int i = 0; i <= steps; ++i) points.push_back(at(range_m, low + (high - low) * i / steps));
    return points;
  }

  // Draws white lines with a dark edge, which are visible on any color.
  void grid_line(const std::vector<PlotPoint>& points) {
    line(points, Rgb8{}, 2 * hair(), 0.15);
    line(points, kWhite, hair(), 0.45);
  }

  double ring_step() const { return tick_step(around_.fan.max_range_m(), 5); }

  void draw_rings() {
    const double step = ring_step();
    for (const double range : ticks_in(0, around_.fan.max_range_m() * 0.995, step)) {
      if (range > around_.fan.min_range_m()) grid_line(arc(range));
    }
  }

  // Labels of spokes are outside the fan's arc.
  void draw_spokes() {
    const double low = degrees(around_.fan.min_azimuth_rad());
    const double high = degrees(around_.fan.max_azimuth_rad());
    if (high - low < kMinSpokedFan) return;
    const double step = high - low > 100 ? 30 : high - low > 50 ? 15 : 10;
    const double far = around_.fan.max_range_m();
    // Not at the edges of the fan, where they would overlap the axis and color bar.
    for (const double azimuth : ticks_in(low + 2, high - 2, step)) {
      if (std::abs(azimuth) > 179) continue;
      const double angle = radians(azimuth);
      const PlotPoint outer = at(far, angle);
      grid_line({at(around_.fan.min_range_m(), angle), outer});
      const double gap = 0.55 * l_.em;
      const double lean = std::sin(angle);
      const Anchor anchor = lean > 0.5 ? Anchor::end : lean < -0.5 ? Anchor::start : Anchor::middle;
      text(outer.x - gap * lean, outer.y - gap * std::cos(angle) + 0.1 * l_.em,
           tick_text(azimuth, step) + "\xc2\xb0", 0.75 * l_.em, anchor);
    }
  }

  void draw_fan_edge() {
    const PolarFan& fan = around_.fan;
    const double low = fan.min_azimuth_rad(), high = fan.max_azimuth_rad();
    std::vector<PlotPoint> edge = {at(fan.min_range_m(), low)};
    const std::vector<PlotPoint> far = arc(fan.max_range_m());
    edge.insert(edge.end(), far.begin(), far.end());
    edge.push_back(at(fan.min_range_m(), high));
    line(std::move(edge), kInk, hair());
  }

  void draw_axes() {
    const double tick = 0.3 * l_.em;
    const bool polar = around_.view == StoredView::polar;
    const Extent& e = l_.extent;
    line({{double(l_.left), double(l_.top)}, {double(l_.left), bottom()}, {right(), bottom()}},
         kInk, 1.3 * hair());
    if (polar) {
      line({{double(l_.left), double(l_.top)}, {right(), double(l_.top)}, {right(), bottom()}},
           kInk, 1.3 * hair());
    }
    const int most = std::clamp(static_cast<int>(l_.picture_width / (3 * l_.em)), 2, 10);
    const double x_step = tick_step(std::abs(e.right - e.left), most);
    for (const double value : ticks_in(e.left, e.right, x_step)) {
      line({{x_of(value), bottom()}, {x_of(value), bottom() + tick}}, kInk, hair());
      text(x_of(value), bottom() + tick + 1.05 * l_.em, tick_text(value, x_step), l_.em,
           Anchor::middle);
    }
    const int high = std::clamp(static_cast<int>(l_.picture_height / (2.2 * l_.em)), 2, 8);
    const double y_step = tick_step(std::abs(e.top - e.bottom), high);
    for (const double value : ticks_in(e.bottom, e.top, y_step)) {
      line({{l_.left - tick, y_of(value)}, {double(l_.left), y_of(value)}}, kInk, hair());
      text(l_.left - tick - 0.25 * l_.em, y_of(value) + 0.35 * l_.em, tick_text(value, y_step),
           l_.em, Anchor::end);
    }
    text(l_.left + l_.picture_width / 2.0, bottom() + 2.75 * l_.em,
         polar ? "azimuth (\xc2\xb0), positive to port" : "to port (m)", l_.em, Anchor::middle);
    text(l_.left - 3.35 * l_.em, l_.top + l_.picture_height / 2.0,
         polar ? "slant range (m)" : "ahead (m)", l_.em, Anchor::middle, true);
  }

  void draw_bar(const ColourBar& bar) {
    const int width = static_cast<int>(std::lround(0.85 * l_.em));
    const int height = std::min(l_.picture_height, static_cast<int>(24 * l_.em));
    const int x = static_cast<int>(std::lround(right() + 1.5 * l_.em));
    const int y = l_.top + (l_.picture_height - height) / 2;
    RgbImage image(width, height, kWhite);
    for (int row = 0; row < height; ++row) {
      const Rgb8 colour = colour_at(*bar.map, 1 - (row + 0.5) / height);
      for (int column = 0; column < width; ++column) {
        image.set(static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(column),
                  colour);
      }
    }
    drawing_.items.emplace_back(DrawnPicture{x, y, std::move(image)});
    const double edge = x + width;
    line({{double(x), double(y)},
          {edge, double(y)},
          {edge, double(y + height)},
          {double(x), double(y + height)},
          {double(x), double(y)}},
         kInk, hair());
    const double span = bar.limits[1] - bar.limits[0];
    const double step = tick_step(span, std::clamp(static_cast<int>(height / (2 * l_.em)), 2, 8));
    for (const double value : ticks_in(bar.limits[0], bar.limits[1], step)) {
      const double place = y + height * (bar.limits[1] - value) / span;
      line({{edge, place}, {edge + 0.25 * l_.em, place}}, kInk, hair());
      text(edge + 0.45 * l_.em, place + 0.35 * l_.em, tick_text(value, step), l_.em, Anchor::start);
    }
    text(edge + 3.8 * l_.em, y + height / 2.0, bar.label, l_.em, Anchor::middle, true);
  }

  void draw_legend() {
    const std::size_t rows = (std::min<std::size_t>(around_.legend.size(), kMaxLegend + 1) +
                              static_cast<std::size_t>(l_.legend_columns) - 1) /
                             static_cast<std::size_t>(l_.legend_columns);
    for (std::size_t i = 0; i < around_.legend.size() && i <= kMaxLegend; ++i) {
      const double x = l_.legend_x + static_cast<double>(i / rows) * l_.legend_column_width;
      const double y = l_.legend_y + static_cast<double>(i % rows) * kLegendRow * l_.em;
      if (i == kMaxLegend) {
        text(x, y + 0.75 * l_.em,
             "and " + std::to_string(around_.legend.size() - kMaxLegend) + " more",
             kLegendSize * l_.em, Anchor::start);
        return;
      }
      drawing_.items.emplace_back(
          DrawnBox{x, y, kSwatch * l_.em, kSwatch * l_.em, around_.legend[i].colour});
      text(x + 1.25 * l_.em, y + 0.75 * l_.em, cut(around_.legend[i].name, 28), kLegendSize * l_.em,
           Anchor::start);
    }
  }

  void draw_title(const std::string& title) {
    if (title.empty()) return;
    const double size = 1.1 * l_.em;
    text(l_.left, 1.5 * l_.em,
         cut(title, static_cast<std::size_t>((l_.width - l_.left) / (0.55 * size))), size,
         Anchor::start);
  }

  const Layout& l_;
  const Surroundings& around_;
  Drawing drawing_;
};

}  // namespace

Layout layout_of(const Surroundings& around, int width_px) {
  Layout l;
  l.width = even(width_px);
  l.em = l.width * 0.026;
  const bool polar = around.view == StoredView::polar;
  l.extent = polar ? polar_extent(around.fan) : cartesian_extent(around.fan);
  const std::size_t entries = std::min<std::size_t>(around.legend.size(), kMaxLegend + 1);
  const double column = legend_text_width(around.legend, l.em) + 2 * l.em;
  const bool beside = entries > 0 && !around.bar;
  l.left = static_cast<int>(std::lround(4.6 * l.em));
  const double margin = around.bar ? 6.7 * l.em : beside ? column + 1.2 * l.em : 1.2 * l.em;
  const double space = l.width - l.left - margin;
  const double span = std::abs(l.extent.right - l.extent.left);
  const double rise = std::abs(l.extent.top - l.extent.bottom);
  const double aspect = polar ? 0.8 : rise / span;
  // A narrow fan is tall: limits the height to about the width.
  const double height = std::min(space * aspect, 0.95 * l.width);
  l.picture_height = std::max(2, static_cast<int>(std::lround(height)));
  l.picture_width = std::max(2, static_cast<int>(std::lround(height / aspect)));
  l.left += static_cast<int>((space - l.picture_width) / 2);
  l.top = static_cast<int>(
      std::lround((around.has_title ? 2.2 : 0.7) * l.em + (polar ? 0 : 1.2 * l.em)));
  double below = l.top + l.picture_height + 3.4 * l.em;
  if (beside) {
    l.legend_x = l.left + l.picture_width + 1.4 * l.em;
    l.legend_y = l.top + 0.2 * l.em;
    below = std::max(below, l.legend_y + static_cast<double>(entries) * kLegendRow * l.em);
  } else if (entries > 0) {
    const double room = l.width - 2 * l.em;
    l.legend_columns = std::clamp(static_cast<int>(room / column), 1, static_cast<int>(entries));
    const auto columns = static_cast<std::size_t>(l.legend_columns);
    l.legend_x = std::max(1.0 * l.em, (l.width - column * l.legend_columns) / 2);
    l.legend_y = below + 0.2 * l.em;
    below = l.legend_y + static_cast<double>((entries + columns - 1) / columns) * kLegendRow * l.em;
  }
  l.legend_column_width = column;
  l.height = even(below + 0.4 * l.em);
  return l;
}

Drawing compose(const Layout& layout, const Surroundings& around, RgbImage image,
                const std::string& title) {
  return Composer(layout, around).compose(std::move(image), title);
}

double tick_step(double span, int most) {
  const double decade = std::pow(10.0, std::floor(std::log10(span / most)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade * most >= span * (1 - 1e-9)) return factor * decade;
  }
  return 10 * decade;
}

std::vector<double> ticks_in(double end, double other_end, double step) {
  const double low = std::min(end, other_end), high = std::max(end, other_end);
  std::vector<double> ticks;
  // Ticks are counted in steps, so that rounding errors do not add up.
  for (double n = std::ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; ++n) {
    ticks.push_back(n == 0 ? 0.0 : n * step);
  }
  return ticks;
}

std::string tick_text(double value, double step) {
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  const std::string text = fmt::format("{:.{}f}", std::abs(value), decimals);
  const bool is_zero = text.find_first_not_of("0.") == std::string::npos;
  return value < 0 && !is_zero ? "\xe2\x88\x92" + text : text;
}

}  // namespace ensonify
