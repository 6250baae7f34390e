// Animated WebP.
#include "formats/webp.h"
#include "figure/animation.h"
#include "formats/output_place.h"

namespace ensonify {
namespace {

class WebpSink : public AnimationSink {
 public:
  WebpSink(std::filesystem::path path, const AnimationFormat& format)
      : path_(std::move(path)), animation_(format.width, format.height, format.fps) {}

  Status add(const RgbImage& frame) override { return animation_.add(frame.rgb); }

  Status finish() override {
    const auto bytes = animation_.finish();
    return bytes ? write_whole(path_, *bytes) : Status(bytes.error());
  }

 private:
  std::filesystem::path path_;
  WebpAnimation animation_;
};

}  // namespace

Result<std::unique_ptr<AnimationSink>> open_webp(const std::filesystem::path& path,
                                                 const AnimationFormat& format) {
  return std::unique_ptr<AnimationSink>(std::make_unique<WebpSink>(path, format));
}

}  // namespace ensonify
