#include "trace/volume.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "core/error.h"
#include "trace/echo.h"

namespace ensonify {
namespace {

// All rays of a sector that reach some range, together: their weights dOmega B_el^2 B_tx^2 and the
// first two moments of their elevation.
struct Reach {
  double range_m = 0;  // as far as the nearest of them goes
  double weight = 0, elevation = 0, elevation_square = 0;
};

// By rising range. Each entry holds its own ray and all that go farther.
std::vector<Reach> reaches_of_sector(const Fan& fan, std::span<const Hit> hits, int beam,
                                     const Sonar& sonar) {
  std::vector<Reach> rays;
  rays.reserve(fan.rays_per_beam());
  for (int a = 0; a < fan.rays_azimuth; ++a) {
    const double transmit = transmit_pattern(
        fan.azimuth_rad[std::size_t(beam) * fan.rays_azimuth + a], sonar.transmit_width_rad);
    for (int e = 0; e < fan.rays_elevation; ++e) {
      const Hit& hit = hits[ray_index(fan, beam, a, e)];
      const double end = hit.instance == 0 ? std::numeric_limits<double>::infinity() : hit.range_m;
      if (!(end > 0)) continue;
      const double elevation = fan.elevation_rad[e];
      const double amplitude = line_pattern(elevation, sonar.elevation_width_rad) * transmit;
      const double weight = fan.solid_angle_sr[e] * amplitude * amplitude;
      rays.push_back({end, weight, weight * elevation, weight * elevation * elevation});
    }
  }
  std::stable_sort(rays.begin(), rays.end(),
                   [](const Reach& a, const Reach& b) { return a.range_m < b.range_m; });
  for (std::size_t i = rays.size(); i-- > 1;) {
    rays[i - 1].weight += rays[i].weight;
    rays[i - 1].elevation += rays[i].elevation;
    rays[i - 1].elevation_square += rays[i].elevation_square;
  }
  return rays;
}

}  // namespace

std::vector<VolumeEcho> volume_echoes(const Fan& fan, std::span<const Hit> hits,
                                      const std::vector<UniformVolume>& volumes, const Sonar& sonar,
                                      const Water& water, const Record& record,
                                      const Workers& workers) {
  ENSONIFY_ASSERT(hits.size() == fan.size());
  std::vector<VolumeEcho> echoes(volumes.size());
  const std::size_t pixels = std::size_t(fan.beams) * record.samples;
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    echoes[v].instance = volumes[v].instance;
    echoes[v].energy.assign(pixels, 0);
    echoes[v].elevation_rad.assign(pixels, 0);
    echoes[v].elevation_square.assign(pixels, 0);
  }
  if (volumes.empty()) return echoes;
  const double depth_m = water.sound_speed_m_s / (2 * sonar.bandwidth_hz);
  workers.for_each(fan.beams, [&](std::size_t beam) {
    const std::vector<Reach> reaches = reaches_of_sector(fan, hits, static_cast<int>(beam), sonar);
    std::size_t next = 0;
    for (int n = 1; n < record.samples; ++n) {
      const double range = sample_range_m(sonar, water, n);
      while (next < reaches.size() && reaches[next].range_m < range) ++next;
      if (next == reaches.size()) break;
      const Reach& open = reaches[next];
      if (!in_range(range, sonar) || !(open.weight > 0)) continue;
      const double loss = two_way_loss(range, water.absorption_db_m);
      const double per_strength = open.weight * range * range * depth_m * loss * loss;
      const std::size_t pixel = beam * record.samples + n;
      for (std::size_t v = 0; v < volumes.size(); ++v) {
        echoes[v].energy[pixel] = static_cast<float>(volumes[v].strength_per_m * per_strength);
        echoes[v].elevation_rad[pixel] = static_cast<float>(open.elevation / open.weight);
        echoes[v].elevation_square[pixel] = static_cast<float>(open.elevation_square / open.weight);
      }
    }
  });
  return echoes;
}

}  // namespace ensonify
