#include "formats/webp.h"

#include <webp/encode.h>
#include <webp/mux.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <new>
#include <vector>

namespace ensonify {
namespace {

// From 0 (fast) to 6 (small): higher ones take at least twice the time to save 2 to 5% of the
// bytes.
constexpr int kLossyMethod = 2, kLosslessMethod = 1;
constexpr float kAnimationQuality = 85;

struct Picture {
  Picture(int width, int height) {
    if (!WebPPictureInit(&webp)) throw std::bad_alloc();
    webp.width = width;
    webp.height = height;
    WebPMemoryWriterInit(&memory);
    webp.writer = WebPMemoryWrite;
    webp.custom_ptr = &memory;
  }
  ~Picture() {
    WebPPictureFree(&webp);
    WebPMemoryWriterClear(&memory);
  }
  Picture(const Picture&) = delete;
  Picture& operator=(const Picture&) = delete;

  WebPPicture webp{};
  WebPMemoryWriter memory{};
};

std::string text_of(const void* bytes, std::size_t size) {
  return {static_cast<const char*>(bytes), size};
}

Result<std::string> encoded(const WebPConfig& config, Picture& picture) {
  if (!WebPEncode(&config, &picture.webp)) {
    if (picture.webp.error_code == VP8_ENC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    return Error{ErrorKind::bug, "WebP cannot encode an image: error " +
                                     std::to_string(static_cast<int>(picture.webp.error_code))};
  }
  return text_of(picture.memory.mem, picture.memory.size);
}

void allocate(Picture& picture) {
  if (!WebPPictureAlloc(&picture.webp)) throw std::bad_alloc();
}

// Luma of a gray value, in the limited range that WebP decoders expect.
constexpr std::array<std::uint8_t, 256> kLuma = [] {
  std::array<std::uint8_t, 256> luma{};
  for (int v = 0; v < 256; ++v) luma[v] = static_cast<std::uint8_t>(16 + (v * 219 + 127) / 255);
  return luma;
}();

Result<std::string> lossless(std::span<const std::uint32_t> argb, int width, int height) {
  WebPConfig config;
  if (!WebPConfigInit(&config))
    return Error{ErrorKind::bug, "libwebp has another version than its headers"};
  config.lossless = 1;
  config.method = kLosslessMethod;
  config.quality = 40;
  config.exact = 1;
  Picture picture(width, height);
  picture.webp.use_argb = 1;
  allocate(picture);
  for (int row = 0; row < height; ++row) {
    std::copy_n(argb.data() + static_cast<std::ptrdiff_t>(row) * width, width,
                picture.webp.argb + static_cast<std::ptrdiff_t>(row) * picture.webp.argb_stride);
  }
  return encoded(config, picture);
}

}  // namespace

Result<std::string> lossy_grey(std::span<const std::uint8_t> grey, int width, int height,
                               int quality) {
  WebPConfig config;
  if (!WebPConfigInit(&config))
    return Error{ErrorKind::bug, "libwebp has another version than its headers"};
  config.quality = static_cast<float>(quality);
  config.method = kLossyMethod;
  config.filter_strength = 0;  // smoothing takes the speckle away
  config.autofilter = 0;
  config.sns_strength = 0;
  config.segments = 1;
  Picture picture(width, height);
  allocate(picture);
  for (int row = 0; row < height; ++row) {
    std::transform(grey.begin() + static_cast<std::ptrdiff_t>(row) * width,
                   grey.begin() + static_cast<std::ptrdiff_t>(row + 1) * width,
                   picture.webp.y + static_cast<std::ptrdiff_t>(row) * picture.webp.y_stride,
                   [](std::uint8_t v) { return kLuma[v]; });
  }
  const auto chroma =
      static_cast<std::size_t>(picture.webp.uv_stride) * static_cast<std::size_t>((height + 1) / 2);
  std::memset(picture.webp.u, 128, chroma);
  std::memset(picture.webp.v, 128, chroma);
  return encoded(config, picture);
}

Result<std::string> lossy_rgb(std::span<const std::uint8_t> rgb, int width, int height,
                              int quality) {
  WebPConfig config;
  if (!WebPConfigPreset(&config, WEBP_PRESET_PHOTO, static_cast<float>(quality)))
    return Error{ErrorKind::bug, "libwebp has another version than its headers"};
  config.method = kLossyMethod;
  Picture picture(width, height);
  if (!WebPPictureImportRGB(&picture.webp, rgb.data(), 3 * width)) throw std::bad_alloc();
  return encoded(config, picture);
}

Result<std::string> lossless_grey(std::span<const std::uint8_t> grey, int width, int height) {
  std::vector<std::uint32_t> argb(grey.size());
  std::transform(grey.begin(), grey.end(), argb.begin(),
                 [](std::uint8_t v) { return 0xff000000u | v * 0x010101u; });
  return lossless(argb, width, height);
}

Result<std::string> lossless_rgb(std::span<const std::uint32_t> pixels, int width, int height) {
  std::vector<std::uint32_t> argb(pixels.size());
  std::transform(pixels.begin(), pixels.end(), argb.begin(),
                 [](std::uint32_t v) { return 0xff000000u | v; });
  return lossless(argb, width, height);
}

struct WebpAnimation::Encoder {
  Encoder(int width, int height) {
    WebPAnimEncoderOptions options;
    if (!WebPAnimEncoderOptionsInit(&options) || !WebPConfigInit(&config)) return;
    config.quality = kAnimationQuality;
    config.use_sharp_yuv = 1;
    webp = WebPAnimEncoderNew(width, height, &options);
  }
  ~Encoder() { WebPAnimEncoderDelete(webp); }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  Error failed() const {
    const char* why = webp ? WebPAnimEncoderGetError(webp) : "cannot start";
    return {ErrorKind::bug, std::string("encoding an animated WebP: ") + why};
  }

  WebPConfig config{};
  WebPAnimEncoder* webp = nullptr;
};

WebpAnimation::WebpAnimation(int width, int height, double fps)
    : width_(width),
      height_(height),
      fps_(fps),
      encoder_(std::make_unique<Encoder>(width, height)) {}

WebpAnimation::~WebpAnimation() = default;

int WebpAnimation::time_ms() const {
  return static_cast<int>(std::lround(1000.0 * frames_ / fps_));
}

Status WebpAnimation::add(std::span<const std::uint8_t> rgb) {
  ENSONIFY_ASSERT(rgb.size() == std::size_t{3} * static_cast<std::size_t>(width_) *
                                    static_cast<std::size_t>(height_));
  if (!encoder_->webp) return encoder_->failed();
  Picture picture(width_, height_);
  picture.webp.use_argb = 1;
  if (!WebPPictureImportRGB(&picture.webp, rgb.data(), 3 * width_)) throw std::bad_alloc();
  if (!WebPAnimEncoderAdd(encoder_->webp, &picture.webp, time_ms(), &encoder_->config)) {
    return encoder_->failed();
  }
  ++frames_;
  return {};
}

Result<std::string> WebpAnimation::finish() {
  WebPData data;
  WebPDataInit(&data);
  // An empty frame gives the end of the last one.
  if (!encoder_->webp || !WebPAnimEncoderAdd(encoder_->webp, nullptr, time_ms(), nullptr) ||
      !WebPAnimEncoderAssemble(encoder_->webp, &data)) {
    return encoder_->failed();
  }
  std::string bytes = text_of(data.bytes, data.size);
  WebPDataClear(&data);
  return bytes;
}

}  // namespace ensonify
