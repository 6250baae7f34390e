// Writes frames to an animated file.
//
//   AnimationSink    takes frames
//   open_webp        animated WebP
//   open_mp4         MP4, by the program ffmpeg
#pragma once

#include <filesystem>
#include <memory>

#include "figure/drawing.h"

namespace ensonify {

class AnimationSink {
 public:
  virtual ~AnimationSink() = default;  // drops what was not finished
  virtual Status add(const RgbImage& frame) = 0;
  virtual Status finish() = 0;
};

struct AnimationFormat {
  int width = 0, height = 0;  // of every frame
  double fps = 0;
};

// Held in memory until finished, a few hundred kB per frame.
Result<std::unique_ptr<AnimationSink>> open_webp(const std::filesystem::path& path,
                                                 const AnimationFormat& format);

// Passes each frame to ffmpeg. Needs even width and height. Errors: (usage) ffmpeg is not on PATH;
// (io) it failed, with what it said.
Result<std::unique_ptr<AnimationSink>> open_mp4(const std::filesystem::path& path,
                                                const AnimationFormat& format);

}  // namespace ensonify
