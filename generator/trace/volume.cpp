#include "trace/volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "core/error.h"
#include "trace/echo.h"

namespace ensonify {
namespace {

// Sums over all rays of a beam cell that reach some range: their weights dOmega B_el^2 B_tx^2 and
// the first two moments of their elevation.
struct Reach {
  double range_m = 0;  // where the shortest of them ends
  double weight = 0, elevation = 0, elevation_square = 0;
};

// Rows [first, last) of the fan.
struct FanRows {
  int first = 0, last = 0;
};

FanRows all_rows(const Fan& fan) { return {0, fan.rays_elevation}; }

// Sorted by rising range. Each entry includes its own ray and all longer ones.
std::vector<Reach> reaches_of_sector(const Fan& fan, std::span<const Hit> hits, int beam,
                                     FanRows rows, const Sonar& sonar) {
  std::vector<Reach> rays;
  rays.reserve(fan.rays_per_beam());
  for (int a = 0; a < fan.rays_azimuth; ++a) {
    const double transmit = transmit_pattern(
        fan.azimuth_rad[std::size_t(beam) * fan.rays_azimuth + a], sonar.transmit_width_rad);
    for (int e = rows.first; e < rows.last; ++e) {
      const Hit& hit = hits[ray_index(fan, beam, a, e)];
      const double end = hit.instance == 0 ? std::numeric_limits<double>::infinity() : hit.range_m;
      if (!(end > 0)) continue;
      const double elevation = fan.elevation_rad[e];
      const double amplitude = elevation_pattern(sonar, elevation) * transmit;
      const double weight = fan.cell_sr(beam, e) * amplitude * amplitude;
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

// Half a range cell: cell n consists of the steps 2n - 1 and 2n of a ray.
double step_of(const Sonar& sonar, const Water& water) {
  return water.sound_speed_m_s / (4 * sonar.bandwidth_hz);
}

bool attenuates(const Volume& volume) { return volume.extinction_db_m > 0; }

// Sums for one volume in one beam cell.
struct Cells {
  std::vector<double> energy, elevation, elevation_square;
};

// Marches through the volumes of one beam cell, if any volume has bounds, patches or extinction.
class SectorMarch {
 public:
  SectorMarch(const Fan& fan, const std::vector<Volume>& volumes, const Pose& pose,
              const Sonar& sonar, const Water& water, int samples)
      : fan_(fan),
        volumes_(volumes),
        pose_(pose),
        sonar_(sonar),
        columns_(volumes.size()),
        mean_columns_(volumes.size()) {
    step_m_ = step_of(sonar, water);
    for (int n = 0; n < samples; ++n) {
      const double range = sample_range_m(sonar, water, n);
      const double loss = two_way_loss(range, water.absorption_db_m);
      cell_loss_.push_back(n > 0 && in_range(range, sonar) ? range * range * loss * loss : 0);
    }
    const std::vector<double> none(samples, 0.0);
    cells_.assign(volumes.size(), {none, none, none});
  }

  void add_beam(std::span<const Hit> hits, int beam, FanRows rows) {
    const double longest_m = step_m_ * (2 * static_cast<double>(cell_loss_.size()) - 1);
    for (int a = 0; a < fan_.rays_azimuth; ++a) {
      const double azimuth = fan_.azimuth_rad[std::size_t(beam) * fan_.rays_azimuth + a];
      const double transmit = transmit_pattern(azimuth, sonar_.transmit_width_rad);
      for (int e = rows.first; e < rows.last; ++e) {
        const Hit& hit = hits[ray_index(fan_, beam, a, e)];
        const double end = hit.instance == 0 ? longest_m : std::min(hit.range_m, longest_m);
        if (!(end > 0)) continue;
        const double elevation = fan_.elevation_rad[e];
        const double amplitude = elevation_pattern(sonar_, elevation) * transmit;
        const Vec3 direction = rotate(pose_.rotation, unit_vector(azimuth, elevation));
        for (std::size_t v = 0; v < volumes_.size(); ++v) {
          const Ray ray{pose_.position_m, direction};
          march(volumes_[v], ray, step_m_, end, columns_[v]);
          if (has_mean(volumes_[v])) march(volumes_[v], ray, step_m_, end, mean_columns_[v], false);
        }
        add_ray(fan_.cell_sr(beam, e) * amplitude * amplitude, elevation);
      }
    }
  }

  // Moves the sums to the echoes of a beam, which begin at `row`, and resets them.
  void move_to(std::vector<VolumeEcho>& echoes, std::size_t row) {
    const std::size_t samples = cell_loss_.size();
    for (std::size_t v = 0; v < volumes_.size(); ++v) {
      Cells& cells = cells_[v];
      for (std::size_t n = 0; n < samples; ++n) {
        const double energy = cells.energy[n];
        if (!(energy > 0)) continue;
        const std::size_t pixel = row * samples + n;
        echoes[v].energy[pixel] = static_cast<float>(energy);
        echoes[v].elevation_rad[pixel] = static_cast<float>(cells.elevation[n] / energy);
        echoes[v].elevation_square[pixel] = static_cast<float>(cells.elevation_square[n] / energy);
        cells.energy[n] = cells.elevation[n] = cells.elevation_square[n] = 0;
      }
    }
  }

 private:
  // Adds the columns of one ray to the sums.
  void add_ray(double weight, double elevation_rad) {
    constexpr double kNepers_per_db = 0.2302585092994045684;  // ln 10 / 10: energy
    int first = std::numeric_limits<int>::max(), last = 0;
    for (const DensityColumn& column : columns_) {
      if (column.first == column.last) continue;
      first = std::min(first, column.first);
      last = std::max(last, column.last);
    }
    const int last_step = 2 * static_cast<int>(cell_loss_.size()) - 1;
    double depth = 0;  // two-way, nepers of energy
    for (int k = first; k < std::min(last, last_step); ++k) {
      double more = 0;
      for (std::size_t v = 0; v < volumes_.size(); ++v) {
        const DensityColumn& column = has_mean(volumes_[v]) ? mean_columns_[v] : columns_[v];
        more += 2 * kNepers_per_db * volumes_[v].extinction_db_m * length_in(column, k);
      }
      // The mean over the step of the energy that is left.
      const double before = depth > 0 ? std::exp(-depth) : 1;
      const double left = before * (more > 0 ? -std::expm1(-more) / more : 1.0);
      depth += more;
      const std::size_t n = (std::size_t(k) + 1) / 2;
      const double per_length = weight * cell_loss_[n] * left;
      if (!(per_length > 0)) continue;
      for (std::size_t v = 0; v < volumes_.size(); ++v) {
        const double energy = volumes_[v].strength_per_m * length_in(columns_[v], k) * per_length;
        cells_[v].energy[n] += energy;
        cells_[v].elevation[n] += energy * elevation_rad;
        cells_[v].elevation_square[n] += energy * elevation_rad * elevation_rad;
      }
    }
  }

  // Whether extinction follows another density than the echo.
  static bool has_mean(const Volume& volume) {
    return volume.patches != nullptr && volume.extinction_db_m > 0;
  }

  static double length_in(const DensityColumn& column, int step) {
    return step >= column.first && step < column.last ? column.length_m[step] : 0;
  }

  const Fan& fan_;
  const std::vector<Volume>& volumes_;
  const Pose& pose_;
  const Sonar& sonar_;
  double step_m_ = 0;
  std::vector<double> cell_loss_;            // [samples], r^2 (two_way_loss)^2; 0: not heard
  std::vector<DensityColumn> columns_;       // of one ray, by volume
  std::vector<DensityColumn> mean_columns_;  // without patches, where has_mean
  std::vector<Cells> cells_;                 // of one beam cell, by volume
};

// The beam cell of a beam, if no volume has bounds, patches or extinction. `echoes` has it at
// `row`.
void add_open_beam(const Fan& fan, std::span<const Hit> hits, const std::vector<Volume>& volumes,
                   const Sonar& sonar, const Water& water, const Record& record, int beam,
                   FanRows rows, std::size_t row, std::vector<VolumeEcho>& echoes) {
  const double depth_m = water.sound_speed_m_s / (2 * sonar.bandwidth_hz);
  const std::vector<Reach> reaches = reaches_of_sector(fan, hits, beam, rows, sonar);
  std::size_t next = 0;
  for (int n = 1; n < record.samples; ++n) {
    const double range = sample_range_m(sonar, water, n);
    while (next < reaches.size() && reaches[next].range_m < range) ++next;
    if (next == reaches.size()) break;
    const Reach& open = reaches[next];
    if (!in_range(range, sonar) || !(open.weight > 0)) continue;
    const double loss = two_way_loss(range, water.absorption_db_m);
    const double per_strength = open.weight * range * range * depth_m * loss * loss;
    const std::size_t pixel = row * record.samples + n;
    for (std::size_t v = 0; v < volumes.size(); ++v) {
      echoes[v].energy[pixel] = static_cast<float>(volumes[v].strength_per_m * per_strength);
      echoes[v].elevation_rad[pixel] = static_cast<float>(open.elevation / open.weight);
      echoes[v].elevation_square[pixel] = static_cast<float>(open.elevation_square / open.weight);
    }
  }
}

std::vector<VolumeEcho> silent_echoes(const std::vector<Volume>& volumes, std::size_t pixels) {
  std::vector<VolumeEcho> echoes(volumes.size());
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    echoes[v].instance = volumes[v].instance;
    echoes[v].energy.assign(pixels, 0);
    echoes[v].elevation_rad.assign(pixels, 0);
    echoes[v].elevation_square.assign(pixels, 0);
  }
  return echoes;
}

bool is_open(const std::vector<Volume>& volumes) {
  return std::all_of(volumes.begin(), volumes.end(), [](const Volume& volume) {
    return !attenuates(volume) && !volume.patches &&
           std::holds_alternative<DensityEverywhere>(volume.density);
  });
}

// Beam cells are processed in blocks, so that buffers are made once for several.
constexpr std::size_t kSectors = 8;

// The rows of the fan with the elevations of a step. Steps narrower than a ray may have none.
struct StepRows {
  std::int16_t step = 0;
  FanRows rows;
};

std::vector<StepRows> steps_of(const Fan& fan, double step_rad) {
  std::vector<StepRows> steps;
  for (int e = 0; e < fan.rays_elevation; ++e) {
    const auto elevation_rad = static_cast<float>(fan.elevation_rad[e]);
    const std::int16_t step = elevation_step_of(elevation_rad, step_rad);
    if (steps.empty() || steps.back().step != step) steps.push_back({step, {e, e}});
    steps.back().rows.last = e + 1;
  }
  return steps;
}

// The energies of one beam cell and step.
void append_step(const std::vector<VolumeEcho>& volumes, int beam, std::int16_t step,
                 double source_pa_m, std::vector<ElevationEcho>& echoes) {
  for (const VolumeEcho& volume : volumes) {
    for (std::size_t n = 0; n < volume.energy.size(); ++n) {
      if (!(volume.energy[n] > 0)) continue;
      echoes.push_back(
          {.sample = static_cast<std::int32_t>(n),
           .beam = static_cast<std::uint16_t>(beam),
           .step = step,
           .diffuse_pa2 = static_cast<float>(source_pa_m * source_pa_m * volume.energy[n]),
           .instance = static_cast<std::uint16_t>(volume.instance)});
    }
  }
}

}  // namespace

std::vector<VolumeEcho> volume_echoes(const Fan& fan, std::span<const Hit> hits,
                                      const std::vector<Volume>& volumes,
                                      const Pose& sonar_in_world, const Sonar& sonar,
                                      const Water& water, const Record& record,
                                      const Workers& workers) {
  ENSONIFY_ASSERT(hits.size() == fan.size());
  std::vector<VolumeEcho> echoes = silent_echoes(volumes, std::size_t(fan.beams) * record.samples);
  if (volumes.empty()) return echoes;
  const bool open = is_open(volumes);
  const int beams = fan.beams;
  workers.for_each((beams + kSectors - 1) / kSectors, [&](std::size_t block) {
    const int first = static_cast<int>(block * kSectors);
    const int end = std::min(first + static_cast<int>(kSectors), beams);
    if (open) {
      for (int beam = first; beam < end; ++beam) {
        add_open_beam(fan, hits, volumes, sonar, water, record, beam, all_rows(fan), beam, echoes);
      }
      return;
    }
    SectorMarch sector(fan, volumes, sonar_in_world, sonar, water, record.samples);
    for (int beam = first; beam < end; ++beam) {
      sector.add_beam(hits, beam, all_rows(fan));
      sector.move_to(echoes, beam);
    }
  });
  return echoes;
}

std::vector<ElevationEcho> volume_elevation_echoes(const Fan& fan, std::span<const Hit> hits,
                                                   const std::vector<Volume>& volumes,
                                                   const Pose& sonar_in_world, const Sonar& sonar,
                                                   const Water& water, const Record& record,
                                                   double step_rad, const Workers& workers) {
  ENSONIFY_ASSERT(hits.size() == fan.size() && step_rad > 0);
  if (volumes.empty()) return {};
  const bool open = is_open(volumes);
  const std::vector<StepRows> steps = steps_of(fan, step_rad);
  std::vector<std::vector<ElevationEcho>> by_beam(fan.beams);
  workers.for_each((by_beam.size() + kSectors - 1) / kSectors, [&](std::size_t block) {
    std::optional<SectorMarch> sector;
    if (!open) sector.emplace(fan, volumes, sonar_in_world, sonar, water, record.samples);
    std::vector<VolumeEcho> echoes = silent_echoes(volumes, record.samples);
    for (std::size_t j = block * kSectors; j < std::min((block + 1) * kSectors, by_beam.size());
         ++j) {
      const int beam = static_cast<int>(j);
      for (const StepRows& step : steps) {
        for (VolumeEcho& echo : echoes) std::fill(echo.energy.begin(), echo.energy.end(), 0.0f);
        if (open) {
          add_open_beam(fan, hits, volumes, sonar, water, record, beam, step.rows, 0, echoes);
        } else {
          sector->add_beam(hits, beam, step.rows);
          sector->move_to(echoes, 0);
        }
        append_step(echoes, beam, step.step, source_pressure_pa_m(sonar), by_beam[j]);
      }
    }
  });
  std::size_t count = 0;
  for (const auto& echoes : by_beam) count += echoes.size();
  std::vector<ElevationEcho> all;
  all.reserve(count);
  for (auto& echoes : by_beam) {
    all.insert(all.end(), echoes.begin(), echoes.end());
    echoes = {};
  }
  return all;
}

void attenuate(ScattererList& list, const std::vector<Volume>& volumes, const Pose& sonar_in_world,
               const Sonar& sonar, const Water& water, const Workers& workers) {
  if (std::none_of(volumes.begin(), volumes.end(), attenuates)) return;
  const double step_m = step_of(sonar, water);
  workers.for_each(list.beam_offset.size() - 1, [&](std::size_t beam) {
    DensityColumn column;
    for (std::uint32_t i = list.beam_offset[beam]; i < list.beam_offset[beam + 1]; ++i) {
      Scatterer& s = list.items[i];
      if (s.path != 0) continue;
      const double range = length(s.position_m);
      const Vec3 direction = rotate(sonar_in_world.rotation, (1 / range) * s.position_m);
      const double db =
          extinction_db(volumes, {sonar_in_world.position_m, direction}, step_m, range, column);
      s.gain = static_cast<float>(s.gain * std::pow(10.0, -db / 10));
    }
  });
}

}  // namespace ensonify
