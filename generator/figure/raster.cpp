#include "figure/raster.h"

#include "core/runtime.h"

namespace ensonify {
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
