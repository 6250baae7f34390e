// WebP images in memory.
//
//   lossy_grey     for speckle and the like; decoding changes the values slightly
//   lossy_rgb  lossless_grey  lossless_rgb
//   WebpAnimation   a sequence of frames
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/error.h"

namespace ensonify {

// The longest side that the format allows.
inline constexpr std::uint64_t kWebpMostPixels = 16383;

// Row-major [height x width]; quality 0 to 100. Gray 0 to 255 as a browser shows it.
Result<std::string> lossy_grey(std::span<const std::uint8_t> grey, int width, int height,
                               int quality);

// Red, green and blue of each pixel.
Result<std::string> lossy_rgb(std::span<const std::uint8_t> rgb, int width, int height,
                              int quality);

Result<std::string> lossless_grey(std::span<const std::uint8_t> grey, int width, int height);

// 0x00RRGGBB each.
Result<std::string> lossless_rgb(std::span<const std::uint32_t> pixels, int width, int height);

// Held in memory until finished, a few hundred kB per frame. For text and thin lines.
class WebpAnimation {
 public:
  WebpAnimation(int width, int height, double fps);
  ~WebpAnimation();

  // Row-major, red, green and blue of each pixel.
  Status add(std::span<const std::uint8_t> rgb);
  // Returns the file; call it once. Error (bug): no frame, or libwebp's error.
  Result<std::string> finish();

 private:
  struct Encoder;
  int time_ms() const;

  int width_, height_;
  double fps_;
  int frames_ = 0;
  std::unique_ptr<Encoder> encoder_;
};

}  // namespace ensonify
