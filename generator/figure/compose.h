// An image with its axes, rings, title, color bar and legend.
//
//   Layout     positions of all parts; the same for all frames of an animation
//   layout_of  from the width and the content
//   compose    one frame
//   tick_step  ticks_in  tick_text   round numbers along an axis
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dataset/read_pictures.h"
#include "figure/drawing.h"
#include "figure/paint.h"

namespace ensonify {

struct LegendEntry {
  Rgb8 colour;
  std::string name;
};

struct ColourBar {
  std::string label;  // with its unit
  const ColourMap* map = nullptr;
  std::array<double, 2> limits{};
};

// The parts around every frame.
struct Surroundings {
  StoredView view = StoredView::cartesian;
  PolarFan fan;
  bool has_title = true;
  std::optional<ColourBar> bar;
  std::vector<LegendEntry> legend;  // next to the image, or below it if there is a bar
};

struct Layout {
  int width = 0, height = 0;
  double em = 0;  // size of text
  int left = 0, top = 0, picture_width = 0, picture_height = 0;
  Extent extent;
  int legend_columns = 1;
  double legend_column_width = 0, legend_x = 0, legend_y = 0;
};

inline constexpr int kMaxLegend = 24;  // entries; further ones are only counted

// Width and height are even, as videos want them. Needs width_px >= 200.
Layout layout_of(const Surroundings& around, int width_px);

// `image` has the size of the layout's image.
Drawing compose(const Layout& layout, const Surroundings& around, RgbImage image,
                const std::string& title);

// The smallest step that gives at most `most` steps. Needs span > 0, most >= 1.
double tick_step(double span, int most);

// Ticks in rising order, independent of which end is larger.
std::vector<double> ticks_in(double end, double other_end, double step);

// The text has as many decimals as the step, and a true minus sign.
std::string tick_text(double value, double step);

}  // namespace ensonify
