#include "render/warning.h"

#include <fmt/format.h>

namespace ensonify {

std::string display_warning(const Display& display, const DisplayCounts& counts,
                            const std::string& dataset) {
  if (counts.heard == 0) return {};
  const auto heard = static_cast<double>(counts.heard);
  const double white = static_cast<double>(counts.white) / heard;
  const double black = static_cast<double>(counts.black) / heard;
  std::string shares;
  if (white > kMostWhite) shares = fmt::format("{:.1f} % are white", 100 * white);
  if (black > kMostBlack) {
    shares += fmt::format("{}{:.1f} % are black", shares.empty() ? "" : " and ", 100 * black);
  }
  if (shares.empty()) return {};
  return fmt::format(
      "of the pixels with energy in the 8-bit images, {}, with limits of {:g} and {:g} dB; "
      "`ensonify render {} --name NAME --db MIN:MAX` makes the images again with others",
      shares, display.limits_db[0], display.limits_db[1], dataset);
}

}  // namespace ensonify
