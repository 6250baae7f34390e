// Animated WebP, by libwebp.
#include <webp/encode.h>
#include <webp/mux.h>

#include <cmath>
#include <string_view>

#include "dataset/output.h"
#include "figure/animation.h"

namespace ensonify {
namespace {

constexpr float kQuality = 85;

Error failed(const std::string& what) {
  return {ErrorKind::bug, "encoding an animated WebP: " + what};
}

struct WebpFreed {
  void operator()(WebPAnimEncoder* encoder) const { WebPAnimEncoderDelete(encoder); }
};

struct Picture {
  WebPPicture picture;
  bool ready = WebPPictureInit(&picture) != 0;
  Picture() = default;
  ~Picture() { WebPPictureFree(&picture); }
  Picture(const Picture&) = delete;
  Picture& operator=(const Picture&) = delete;
};

class WebpSink : public AnimationSink {
 public:
  WebpSink(std::filesystem::path path, const AnimationFormat& format)
      : path_(std::move(path)), format_(format) {
    WebPAnimEncoderOptions options;
    if (WebPAnimEncoderOptionsInit(&options) == 0 || WebPConfigInit(&config_) == 0) return;
    // Sharp colours, for texts and thin lines.
    config_.quality = kQuality;
    config_.use_sharp_yuv = 1;
    encoder_.reset(WebPAnimEncoderNew(format.width, format.height, &options));
  }

  Status add(const RgbImage& frame) override {
    Picture p;
    if (!encoder_ || !p.ready) return failed("cannot begin");
    p.picture.use_argb = 1;
    p.picture.width = frame.width;
    p.picture.height = frame.height;
    if (WebPPictureImportRGB(&p.picture, frame.rgb.data(), 3 * frame.width) == 0) {
      return Error{ErrorKind::device, "encoding an animated WebP: out of memory"};
    }
    if (WebPAnimEncoderAdd(encoder_.get(), &p.picture, time_ms(frames_), &config_) == 0) {
      return failed(WebPAnimEncoderGetError(encoder_.get()));
    }
    ++frames_;
    return {};
  }

  Status finish() override {
    WebPData data;
    WebPDataInit(&data);
    // The end of the last frame.
    const bool done = encoder_ &&
                      WebPAnimEncoderAdd(encoder_.get(), nullptr, time_ms(frames_), nullptr) &&
                      WebPAnimEncoderAssemble(encoder_.get(), &data);
    if (!done) return failed(encoder_ ? WebPAnimEncoderGetError(encoder_.get()) : "cannot begin");
    const Status written = write_whole(
        path_, {static_cast<const char*>(static_cast<const void*>(data.bytes)), data.size});
    WebPDataClear(&data);
    return written;
  }

 private:
  int time_ms(int frame) const {
    return static_cast<int>(std::lround(1000.0 * frame / format_.fps));
  }

  std::filesystem::path path_;
  AnimationFormat format_;
  WebPConfig config_{};
  std::unique_ptr<WebPAnimEncoder, WebpFreed> encoder_;
  int frames_ = 0;
};

}  // namespace

Result<std::unique_ptr<AnimationSink>> open_webp(const std::filesystem::path& path,
                                                 const AnimationFormat& format) {
  return std::unique_ptr<AnimationSink>(std::make_unique<WebpSink>(path, format));
}

}  // namespace ensonify
