#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "compare/page_text.h"

namespace ensonify {
namespace {

constexpr double kWidth = 440, kHeight = 230, kLeft = 52, kRight = 10, kTop = 8, kBottom = 40;
constexpr double kBandWidth = 1.96;

struct Point {
  double x = 0, y = 0, error = 0;
};

// Where numbers lie in a plot.
struct Scale {
  double x0 = 0, x1 = 1, y0 = 0, y1 = 1;

  double x(double value) const {
    return kLeft + (value - x0) / (x1 - x0) * (kWidth - kLeft - kRight);
  }
  double y(double value) const {
    return kHeight - kBottom - (value - y0) / (y1 - y0) * (kHeight - kTop - kBottom);
  }
};

std::vector<Point> points_of(const std::vector<double>& positions,
                             const std::vector<double>& values, const std::vector<double>& errors) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < std::min({positions.size(), values.size(), errors.size()}); ++i) {
    if (std::isfinite(values[i]) && std::isfinite(errors[i])) {
      points.push_back({positions[i], values[i], errors[i]});
    }
  }
  return points;
}

// 1, 2 or 5 times a power of ten, so that about `count` of them make up the span.
double tick_step(double span, double count) {
  const double raw = span / count;
  const double power = std::pow(10, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (raw <= factor * power) return factor * power;
  }
  return 10 * power;
}

std::optional<Scale> scale_of(const std::vector<Point>& a, const std::vector<Point>& b) {
  constexpr double kMost = std::numeric_limits<double>::infinity();
  Scale scale{kMost, -kMost, kMost, -kMost};
  for (const auto* points : {&a, &b}) {
    for (const Point& p : *points) {
      scale.x0 = std::min(scale.x0, p.x);
      scale.x1 = std::max(scale.x1, p.x);
      scale.y0 = std::min(scale.y0, p.y - kBandWidth * p.error);
      scale.y1 = std::max(scale.y1, p.y + kBandWidth * p.error);
    }
  }
  if (!(scale.x1 > scale.x0)) return std::nullopt;
  const double margin = scale.y1 > scale.y0 ? 0.05 * (scale.y1 - scale.y0) : 1;
  scale.y0 -= margin;
  scale.y1 += margin;
  return scale;
}

std::string axes_svg(const Scale& scale, const std::string& x_title, const std::string& y_title) {
  std::string svg;
  const double dy = tick_step(scale.y1 - scale.y0, 5), dx = tick_step(scale.x1 - scale.x0, 6);
  for (double y = std::ceil(scale.y0 / dy) * dy; y <= scale.y1; y += dy) {
    const double shown = std::abs(y) < dy / 1e6 ? 0 : y;
    svg += fmt::format(
        "<line class=\"plot-grid\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>"
        "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{:.6g}</text>\n",
        kLeft, kWidth - kRight, scale.y(y), scale.y(y), kLeft - 6, scale.y(y) + 4, shown);
  }
  for (double x = std::ceil(scale.x0 / dx) * dx; x <= scale.x1 + dx / 1e6; x += dx) {
    const double shown = std::abs(x) < dx / 1e6 ? 0 : x;
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:.6g}</text>\n",
                       scale.x(x), kHeight - kBottom + 16, shown);
  }
  svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n",
                     (kLeft + kWidth - kRight) / 2, kHeight - 6, html_text(x_title));
  svg += fmt::format(
      "<text transform=\"translate(12 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
      (kTop + kHeight - kBottom) / 2, html_text(y_title));
  return svg;
}

std::string line_svg(const Scale& scale, const std::vector<Point>& points, const char* name) {
  std::string line, above, below;
  for (const Point& p : points) {
    line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : "L", scale.x(p.x), scale.y(p.y));
    above += fmt::format("{}{:.1f} {:.1f}", above.empty() ? "M" : "L", scale.x(p.x),
                         scale.y(p.y + kBandWidth * p.error));
    below =
        fmt::format("L{:.1f} {:.1f}", scale.x(p.x), scale.y(p.y - kBandWidth * p.error)) + below;
  }
  if (points.empty()) return {};
  return fmt::format(
      "<path class=\"{0}-band\" d=\"{1}{2}Z\"/><path class=\"{0}-line\" d=\"{3}\"/>\n", name, above,
      below, line);
}

std::string svg_of(const std::vector<Point>& real, const std::vector<Point>& simulated,
                   const std::string& x_title, const std::string& y_title,
                   const std::string& label) {
  const auto scale = scale_of(real, simulated);
  if (!scale) return {};
  return fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n", kWidth,
                     kHeight, html_text(label)) +
         axes_svg(*scale, x_title, y_title) + line_svg(*scale, simulated, "simulated") +
         line_svg(*scale, real, "real") + "</svg>";
}

// Takes the mean of the values at positions that both have from each.
void align(std::vector<Point>& real, std::vector<Point>& simulated) {
  double a = 0, b = 0, count = 0;
  for (const Point& p : real) {
    for (const Point& q : simulated) {
      if (std::abs(p.x - q.x) > 1e-9 * (1 + std::abs(p.x))) continue;
      a += p.y;
      b += q.y;
      count += 1;
    }
  }
  if (count == 0) return;
  for (Point& p : real) p.y -= a / count;
  for (Point& q : simulated) q.y -= b / count;
}

}  // namespace

std::string curve_svg(const ComparedStatistic& s) {
  std::vector<Point> real = points_of(s.real_positions, s.real, s.real_error);
  std::vector<Point> simulated = points_of(s.simulated_positions, s.simulated, s.simulated_error);
  if (s.free_constant) align(real, simulated);
  const std::string y_title = s.free_constant ? fmt::format("{}, mean 0", s.unit) : s.unit;
  return svg_of(real, simulated, s.axis, y_title, s.title);
}

std::string histogram_svg(const Comparison& comparison) {
  const auto points = [](const std::vector<double>& shares) {
    std::vector<Point> all;
    for (std::size_t i = 0; i < shares.size(); ++i) {
      all.push_back({kHistogramFrom + static_cast<double>(i) + 0.5, 100 * shares[i], 0});
    }
    return all;
  };
  return svg_of(points(comparison.real_histogram), points(comparison.simulated_histogram),
                "level over the mean level, dB", "% of the pixels per dB",
                "histogram of the level");
}

}  // namespace ensonify
