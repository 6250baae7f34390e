#include "labels/motion.h"

#include <cmath>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/image_planes.h"
#include "labels/beam_pixels.h"

namespace ensonify {
namespace {

const SectorEcho* strongest_of(std::span<const SectorEcho> echoes, std::uint32_t instance) {
  const SectorEcho* strongest = nullptr;
  for (const SectorEcho& echo : echoes) {
    if (echo.instance != instance || echo.bounced) continue;
    if (strongest == nullptr || echo.energy > strongest->energy) strongest = &echo;
  }
  return strongest;
}

void put(const PointMotion& motion, std::size_t pixel, LabelledImage& image) {
  image.point_sample[pixel] = rounded(motion.sample, kMotionQuantum);
  image.point_beam[pixel] = rounded(motion.beam, kMotionQuantum);
  image.motion_samples[pixel] = rounded(motion.sample_there - motion.sample, kMotionQuantum);
  image.motion_beams[pixel] = rounded(motion.beam_there - motion.beam, kMotionQuantum);
  image.motion_state[pixel] = static_cast<std::uint8_t>(motion.state);
  image.motion_occluder[pixel] = motion.occluder;
}

class BeamMotion {
 public:
  BeamMotion(const MotionInput& input, LabelledImage& image) : input_(input), image_(image) {}

  void operator()(int beam) {
    points_.clear();
    for_each_labeled_pixel(input_.heard, image_, beam, sector_, [&](std::size_t pixel, auto echoes) {
      const SectorEcho* point = strongest_of(echoes, image_.instance[pixel]);
      if (point != nullptr) points_.add(pixel, point->item);
    });
    if (points_.items.empty()) return;
    motions_.resize(points_.items.size());
    input_.motions_of(points_.items, motions_);
    for (const PixelItems::Place& place : points_.places) {
      put(motions_[place.item], place.pixel, image_);
    }
  }

 private:
  const MotionInput& input_;
  LabelledImage& image_;
  std::vector<SectorEcho> sector_;
  PixelItems points_;
  std::vector<PointMotion> motions_;
};

}  // namespace

void add_motion(const MotionInput& input, const Workers& workers, LabelledImage& image) {
  for (const ImagePlane& plane : kImagePlanes) {
    if (plane.wanted != &OutputSelection::motion) continue;
    with_plane(image, plane, [&](auto& values) {
      using Value = typename std::decay_t<decltype(values)>::value_type;
      values.assign(image.instance.size(), blank_value<Value>(plane.blank));
    });
  }
  for_each_beam(input.heard.beams, workers, [&] { return BeamMotion(input, image); });
}

}  // namespace ensonify
