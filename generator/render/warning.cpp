#include "render/warning.h"

#include <fmt/format.h>

namespace ensonify {

std::string display_warning(const Display& display, const DisplayCounts& counts,
                            const std::string& dataset) {
  const auto share = [](std::uint64_t part, std::uint64_t whole) {
    return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
  };
  const double white = share(counts.white, counts.all), black = share(counts.black, counts.echo);
  std::string shares;
  if (white > kMostWhite) shares = fmt::format("{:.1f} % of the pixels are white", 100 * white);
  if (black > kMostBlack) {
    shares += fmt::format("{}{:.1f} % of the pixels with echoes are black",
                          shares.empty() ? "" : " and ", 100 * black);
  }
  if (shares.empty()) return {};
  return fmt::format(
      "8-bit images: {} with limits of {:g} and {:g} dB; `ensonify render {} --name NAME --db "
      "MIN:MAX` makes the images again with other limits",
      shares, display.limits_db[0], display.limits_db[1], dataset);
}

}  // namespace ensonify
