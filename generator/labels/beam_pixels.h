// Walks over the pixels of a polar image beam by beam. Private to labels/.
//
//   for_each_beam            by blocks of neighboring beams, in parallel
//   for_each_labeled_pixel   those of a beam with an instance, and their echoes
//   PixelItems               which scatterer belongs to which pixel
//   rounded                  a value as it is stored
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "labels/polar.h"
#include "labels/sector_echoes.h"

namespace ensonify {

// Further digits would fill most of a file without meaning.
inline float rounded(double value, double quantum) {
  return static_cast<float>(std::round(value / quantum) * quantum);
}

// Calls make() once for each block, and the result with each beam of the block.
template <class Make>
void for_each_beam(int beams, const Workers& workers, Make make) {
  // One worker writes this many beams, because their pixels share cache lines.
  constexpr int kTogether = 16;
  workers.for_each(static_cast<std::size_t>((beams + kTogether - 1) / kTogether),
                   [&](std::size_t block) {
                     auto each = make();
                     const int first = static_cast<int>(block) * kTogether;
                     for (int beam = first; beam < std::min(first + kTogether, beams); ++beam) {
                       each(beam);
                     }
                   });
}

// Calls visit(pixel, echoes), nearest pixels first. `sector` holds the echoes of the beam.
template <class Visit>
void for_each_labeled_pixel(const PolarInput& heard, const LabelledImage& image, int beam,
                            std::vector<SectorEcho>& sector, Visit visit) {
  gather_sector(*heard.scatterers, {}, static_cast<std::size_t>(beam), heard.bandwidth_hz, sector);
  EchoWindow window(sector);
  for (int n = 0; n < heard.samples; ++n) {
    const std::span<const SectorEcho> echoes = window.at(n);
    if (echoes.empty()) {
      n = std::max(n, window.silent_until(heard.samples));
      continue;
    }
    const std::size_t pixel = std::size_t(n) * heard.beams + beam;
    if (image.instance[pixel] != 0) visit(pixel, echoes);
  }
}

// Scatterers of pixels, each once, since neighboring pixels often share theirs.
struct PixelItems {
  struct Place {
    std::size_t pixel = 0, item = 0;  // index into items
  };
  std::vector<std::uint32_t> items;
  std::vector<Place> places;

  void clear() {
    items.clear();
    places.clear();
  }
  void add(std::size_t pixel, std::uint32_t item) {
    if (items.empty() || items.back() != item) items.push_back(item);
    places.push_back({pixel, items.size() - 1});
  }
};

}  // namespace ensonify
