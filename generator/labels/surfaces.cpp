#include "labels/surfaces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/image_planes.h"
#include "core/parallel.h"
#include "labels/sector_echoes.h"

namespace ensonify {
namespace {

// Further digits would fill most of a file without meaning.
float rounded(double value, double quantum) {
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

// The echoes of one pixel's instance.
class PixelSurfaces {
 public:
  const SectorEcho* strongest = nullptr;
  const SectorEcho* lowest = nullptr;
  const SectorEcho* highest = nullptr;

  void gather(std::span<const SectorEcho> echoes, std::uint32_t instance) {
    echoes_ = echoes;
    instance_ = instance;
    strongest = lowest = highest = nullptr;
    for (const SectorEcho& echo : echoes) {
      if (!counts(echo)) continue;
      if (strongest == nullptr) strongest = lowest = highest = &echo;
      if (echo.energy > strongest->energy) strongest = &echo;
      if (echo.elevation_rad < lowest->elevation_rad) lowest = &echo;
      if (echo.elevation_rad > highest->elevation_rad) highest = &echo;
    }
  }

  int count(double gap_rad) {
    if (highest->elevation_rad - lowest->elevation_rad <= gap_rad) return 1;
    return surfaces_among([&](const SectorEcho& echo) { return counts(echo); }, gap_rad);
  }

  int count_all(double gap_rad) {
    if (strongest != nullptr &&
        std::ranges::all_of(echoes_, [&](const SectorEcho& echo) { return counts(echo); })) {
      return count(gap_rad);
    }
    const auto is_direct = [](const SectorEcho& echo) { return !echo.bounced; };
    return surfaces_among(is_direct, gap_rad);
  }

 private:
  template <class Counts>
  int surfaces_among(Counts&& counts, double gap_rad) {
    places_.clear();
    for (const SectorEcho& echo : echoes_) {
      if (counts(echo)) places_.emplace_back(echo.instance, echo.elevation_rad);
    }
    std::ranges::sort(places_);
    int surfaces = 0;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      surfaces += i == 0 || places_[i].first != places_[i - 1].first ||
                  places_[i].second - places_[i - 1].second > gap_rad;
    }
    return surfaces;
  }
  bool counts(const SectorEcho& echo) const { return echo.instance == instance_ && !echo.bounced; }

  std::span<const SectorEcho> echoes_;
  std::uint32_t instance_ = 0;
  // Instances and elevations; reused from pixel to pixel.
  std::vector<std::pair<std::uint32_t, double>> places_;
};

class BeamSurfaces {
 public:
  BeamSurfaces(const SurfaceInput& input, LabelledImage& image) : input_(input), image_(image) {}

  void operator()(int beam) {
    points_.clear();
    for_each_labeled_pixel(input_.heard, image_, beam, sector_, [&](std::size_t at, auto echoes) {
      pixel_.gather(echoes, image_.instance[at]);
      image_.layover_count[at] = static_cast<float>(pixel_.count_all(gap_rad_));
      if (pixel_.strongest != nullptr) write_pixel(at);
    });
    write_normals();
  }

 private:
  void write_pixel(std::size_t at) {
    const double metres_per_sample = input_.sound_speed_m_s / (2 * input_.heard.bandwidth_hz);
    const auto put = [&](const SectorEcho& echo, std::vector<float>& elevation_rad,
                         std::vector<float>& range_m) {
      elevation_rad[at] = rounded(echo.elevation_rad, kSurfaceAngleQuantum_rad);
      range_m[at] = rounded(echo.sample * metres_per_sample, kSurfaceRangeQuantum_m);
    };
    put(*pixel_.strongest, image_.surface_elevation_rad, image_.surface_range_m);
    put(*pixel_.lowest, image_.lowest_elevation_rad, image_.lowest_range_m);
    put(*pixel_.highest, image_.highest_elevation_rad, image_.highest_range_m);
    image_.surface_count[at] = static_cast<float>(pixel_.count(gap_rad_));
    points_.add(at, pixel_.strongest->item);
  }

  void write_normals() {
    if (points_.items.empty()) return;
    normals_.resize(points_.items.size());
    input_.normals_at(points_.items, normals_);
    for (const PixelItems::Place& place : points_.places) {
      const Vec3 normal = normals_[place.item];
      image_.surface_normal_x[place.pixel] = rounded(normal.x, kSurfaceNormalQuantum);
      image_.surface_normal_y[place.pixel] = rounded(normal.y, kSurfaceNormalQuantum);
      image_.surface_normal_z[place.pixel] = rounded(normal.z, kSurfaceNormalQuantum);
    }
  }

  const SurfaceInput& input_;
  LabelledImage& image_;
  const double gap_rad_ = kSurfaceGap * input_.elevation_step_rad;
  std::vector<SectorEcho> sector_;
  PixelSurfaces pixel_;
  PixelItems points_;  // strongest scatterers
  std::vector<Vec3> normals_;
};

}  // namespace

void add_surfaces(const SurfaceInput& input, const Workers& workers, LabelledImage& image) {
  for (const ImagePlane& plane : kImagePlanes) {
    if (plane.group() != kSurfacePlanes) continue;
    const auto values = std::get<std::vector<float> ImagePlanes::*>(plane.values);
    if (!(image.*values).empty()) continue;  // polar_image knows the second instance
    (image.*values).assign(image.instance.size(), blank_value<float>(plane.blank));
  }
  for_each_beam(input.heard.beams, workers, [&] { return BeamSurfaces(input, image); });
}

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
