#include "labels/surfaces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/image_planes.h"
#include "labels/sector_echoes.h"

namespace ensonify {
namespace {

// One worker writes this many beams, because their pixels share cache lines.
constexpr int kBeamsTogether = 16;

float rounded(double value, double quantum) {
  return static_cast<float>(std::round(value / quantum) * quantum);
}

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

// Indices of a pixel and of its normal.
struct NormalPlace {
  std::size_t pixel = 0, normal = 0;
};

class BeamSurfaces {
 public:
  BeamSurfaces(const SurfaceInput& input, LabelledImage& image) : input_(input), image_(image) {}

  void write(int beam) {
    const PolarInput& heard = input_.heard;
    gather_sector(*heard.scatterers, {}, static_cast<std::size_t>(beam), heard.bandwidth_hz,
                  sector_);
    items_.clear();
    places_.clear();
    EchoWindow window(sector_);
    for (int n = 0; n < heard.samples; ++n) {
      const std::span<const SectorEcho> echoes = window.at(n);
      if (echoes.empty()) {
        n = std::max(n, window.silent_until(heard.samples));
        continue;
      }
      const std::size_t at = std::size_t(n) * heard.beams + beam;
      if (image_.instance[at] == 0) continue;
      pixel_.gather(echoes, image_.instance[at]);
      image_.layover_count[at] = static_cast<float>(pixel_.count_all(gap_rad_));
      if (pixel_.strongest != nullptr) write_pixel(at);
    }
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
    // This is usually the strongest scatterer of the previous pixel as well.
    const std::uint32_t item = pixel_.strongest->item;
    if (items_.empty() || items_.back() != item) items_.push_back(item);
    places_.push_back({at, items_.size() - 1});
  }

  void write_normals() {
    if (items_.empty()) return;
    normals_.resize(items_.size());
    input_.normals_at(items_, normals_);
    for (const NormalPlace& place : places_) {
      const Vec3 normal = normals_[place.normal];
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
  std::vector<std::uint32_t> items_;  // strongest scatterers
  std::vector<NormalPlace> places_;
  std::vector<Vec3> normals_;
};

}  // namespace

void add_surfaces(const SurfaceInput& input, const Workers& workers, LabelledImage& image) {
  for (const ImagePlane& plane : kImagePlanes) {
    if (!is_surface_plane(plane)) continue;
    const auto values = std::get<std::vector<float> ImagePlanes::*>(plane.values);
    if (!(image.*values).empty()) continue;  // polar_image knows the second instance
    (image.*values).assign(image.instance.size(), blank_value<float>(plane.blank));
  }
  const int beams = input.heard.beams;
  workers.for_each(static_cast<std::size_t>((beams + kBeamsTogether - 1) / kBeamsTogether),
                   [&](std::size_t block) {
                     BeamSurfaces surfaces(input, image);
                     const int first = static_cast<int>(block) * kBeamsTogether;
                     for (int beam = first; beam < std::min(first + kBeamsTogether, beams);
                          ++beam) {
                       surfaces.write(beam);
                     }
                   });
}

}  // namespace ensonify
