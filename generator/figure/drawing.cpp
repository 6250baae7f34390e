#include "figure/drawing.h"

#include <algorithm>
#include <cmath>

#include "core/runtime.h"

namespace ensonify {
namespace {

// Every eighth color of the published tables of 256: viridis, inferno and magma by S. van der Walt,
// N. Smith and E. Firing (CC0), cividis by J. Nunez, C. Anderton and R. Renslow, "Optimizing
// colormaps with consideration for color vision deficiency", PLOS ONE 13 (2018) e0199239. Linear
// between them: the error of a channel is at most 2 of 255, for cividis 6.
constexpr ColourMap kMaps[] = {
    {"cividis",
     {0x00224e, 0x00285b, 0x002e6a, 0x053371, 0x1a386f, 0x273e6e, 0x32436d, 0x3b496c, 0x434e6c,
      0x4b546c, 0x535a6d, 0x5a5f6e, 0x61656f, 0x686a71, 0x6f7073, 0x767676, 0x7d7c78, 0x838179,
      0x8b8778, 0x928d78, 0x9a9376, 0xa29975, 0xaaa073, 0xb3a670, 0xbbad6d, 0xc3b369, 0xccba64,
      0xd4c15f, 0xddc858, 0xe6d051, 0xefd748, 0xf8df3c, 0xfee838}},
    {"viridis",
     {0x440154, 0x470d60, 0x48186a, 0x482374, 0x472d7b, 0x453781, 0x424086, 0x3e4989, 0x3b528b,
      0x375b8d, 0x33638d, 0x2f6b8e, 0x2c728e, 0x297a8e, 0x26828e, 0x23898e, 0x21918c, 0x1f978b,
      0x1f9f88, 0x21a685, 0x27ad81, 0x31b57b, 0x3dbc74, 0x4cc26c, 0x5cc863, 0x6ece58, 0x81d34d,
      0x95d840, 0xaadc32, 0xc0df25, 0xd5e21a, 0xeae51a, 0xfde725}},
    {"inferno",
     {0x000004, 0x040312, 0x0b0724, 0x150b37, 0x210c4a, 0x2f0a5b, 0x3d0965, 0x4a0c6b, 0x57106e,
      0x64156e, 0x71196e, 0x7d1e6d, 0x8a226a, 0x972766, 0xa32c61, 0xb0315b, 0xbc3754, 0xc63d4d,
      0xd04545, 0xda4e3c, 0xe35933, 0xeb6429, 0xf1711f, 0xf67e14, 0xf98c0a, 0xfb9b06, 0xfcaa0f,
      0xfbba1f, 0xf9c932, 0xf5d949, 0xf2e865, 0xf3f586, 0xfcffa4}},
    {"magma",
     {0x000004, 0x030312, 0x0a0822, 0x130d34, 0x1d1147, 0x29115a, 0x36106b, 0x440f76, 0x51127c,
      0x5d177f, 0x6a1c81, 0x762181, 0x832681, 0x902a81, 0x9c2e7f, 0xaa337d, 0xb73779, 0xc23b75,
      0xcf4070, 0xdb476a, 0xe55064, 0xee5b5e, 0xf4695c, 0xf9785d, 0xfb8761, 0xfd9668, 0xfea571,
      0xfeb47b, 0xfec287, 0xfed194, 0xfde0a1, 0xfceeb0, 0xfcfdbf}},
    {"grey",
     {0x000000, 0x080808, 0x101010, 0x181818, 0x202020, 0x282828, 0x303030, 0x383838, 0x404040,
      0x484848, 0x505050, 0x585858, 0x606060, 0x686868, 0x707070, 0x787878, 0x808080, 0x878787,
      0x8f8f8f, 0x979797, 0x9f9f9f, 0xa7a7a7, 0xafafaf, 0xb7b7b7, 0xbfbfbf, 0xc7c7c7, 0xcfcfcf,
      0xd7d7d7, 0xdfdfdf, 0xe7e7e7, 0xefefef, 0xf7f7f7, 0xffffff}},
};

// M. Okabe and K. Ito, "Color Universal Design" (2008), without black.
constexpr std::uint32_t kIdColours[] = {0xe69f00, 0x56b4e9, 0x009e73, 0xd55e00,
                                        0xcc79a7, 0xf0e442, 0x0072b2};

Rgb8 unpack(std::uint32_t colour) {
  return {static_cast<std::uint8_t>(colour >> 16), static_cast<std::uint8_t>(colour >> 8),
          static_cast<std::uint8_t>(colour)};
}

std::uint8_t between(std::uint8_t a, std::uint8_t b, double t) {
  return static_cast<std::uint8_t>(std::lround(a + t * (b - a)));
}

// Hue in turns.
Rgb8 from_hue(double hue, double saturation, double value) {
  const auto channel = [&](double turn) {
    const double h = std::abs(std::fmod(hue + turn, 1.0) * 6 - 3) - 1;
    return static_cast<std::uint8_t>(
        std::lround(255 * value * (1 - saturation * (1 - std::clamp(h, 0.0, 1.0)))));
  };
  return {channel(0), channel(2.0 / 3), channel(1.0 / 3)};
}

}  // namespace

std::span<const ColourMap> colour_maps() { return kMaps; }

const ColourMap* find_colour_map(std::string_view name) {
  for (const ColourMap& map : kMaps) {
    if (name == map.name) return &map;
  }
  return nullptr;
}

Rgb8 colour_at(const ColourMap& map, double value) {
  const double place = std::clamp(value, 0.0, 1.0) * (map.stops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), map.stops.size() - 2);
  const Rgb8 a = unpack(map.stops[below]), b = unpack(map.stops[below + 1]);
  const double t = place - static_cast<double>(below);
  return {between(a.red, b.red, t), between(a.green, b.green, t), between(a.blue, b.blue, t)};
}

Rgb8 id_colour(std::uint32_t id) {
  if (id == 0) return kNoIdColour;
  constexpr std::uint32_t kCount = std::size(kIdColours);
  if (id <= kCount) return unpack(kIdColours[id - 1]);
  // Hues spaced by the golden ratio stay apart from earlier ones; combined with three shades.
  const std::uint32_t more = id - kCount - 1;
  const double values[] = {0.85, 0.6, 0.95}, saturations[] = {0.8, 0.65, 0.4};
  return from_hue(std::fmod(0.13 + more * 0.61803398875, 1.0), saturations[more % 3],
                  values[more % 3]);
}

RgbImage::RgbImage(int w, int h, Rgb8 fill) : width(w), height(h) {
  const auto pixels = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
  rgb.resize(3 * pixels);
  for (std::size_t i = 0; i < pixels; ++i) set(i, fill);
}

Rgb8 RgbImage::at(int x, int y) const {
  const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(x));
  return {rgb.at(i), rgb.at(i + 1), rgb.at(i + 2)};
}

void RgbImage::set(std::size_t pixel, Rgb8 colour) {
  rgb[3 * pixel] = colour.red;
  rgb[3 * pixel + 1] = colour.green;
  rgb[3 * pixel + 2] = colour.blue;
}

namespace {

Result<const RasterApi*> raster() {
  static const Result<void*> entry =
      module_symbol(companion_path(kRasterModule), kRasterEntry,
                    "install cairo (Debian: apt-get install libcairo2)");
  if (!entry) return entry.error();
  return reinterpret_cast<RasterEntry>(*entry)();
}

}  // namespace

Result<RgbImage> draw_raster(const Drawing& drawing) {
  const Result<const RasterApi*> api = raster();
  return api ? (*api)->draw(drawing) : Result<RgbImage>(api.error());
}

Result<std::string> encode_png(const RgbImage& image) {
  const Result<const RasterApi*> api = raster();
  return api ? (*api)->png(image) : Result<std::string>(api.error());
}

}  // namespace ensonify
