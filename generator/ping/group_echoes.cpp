#include "ping/group_echoes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

namespace ensonify {

std::vector<std::uint32_t> beam_offsets(std::span<const Scatterer> sorted, int beams) {
  std::vector<std::uint32_t> offset(std::size_t(beams) + 1, 0);
  for (const Scatterer& s : sorted) ++offset[std::size_t{s.beam} + 1];
  std::partial_sum(offset.begin(), offset.end(), offset.begin());
  return offset;
}

ScattererList with_all_beams(const Fan& fan, ScattererList list, int beams, bool keys_are_rays) {
  if (!fan.is_group) return list;
  for (Scatterer& s : list.items) {
    const auto beam = static_cast<std::uint32_t>(fan.beam_of(s.beam));
    if (keys_are_rays) s.key += (beam - s.beam) * fan.rays_per_beam();
    s.beam = beam;
  }
  list.beam_offset = beam_offsets(list.items, beams);
  return list;
}

void with_all_beams(const Fan& fan, std::span<Scatterer> scatterers) {
  for (Scatterer& s : scatterers) s.beam = static_cast<std::uint32_t>(fan.beam_of(s.beam));
}

PointScatterers points_of_cells(const Fan& fan, PointScatterers points) {
  if (!fan.is_group) return points;
  const auto cell_of = [&](const Scatterer& s) {
    return (static_cast<int>(s.beam) - fan.first_beam) / fan.beam_step;
  };
  const auto is_elsewhere = [&](const Scatterer& s) {
    const int cell = cell_of(s);
    return cell < 0 || cell >= fan.beams || fan.beam_of(cell) != static_cast<int>(s.beam);
  };
  std::erase_if(points.heard, is_elsewhere);
  std::erase_if(points.hidden, [&](const HiddenTarget& t) { return is_elsewhere(t.scatterer); });
  for (HiddenTarget& target : points.hidden) {
    target.scatterer.beam = static_cast<std::uint32_t>(cell_of(target.scatterer));
  }
  return points;
}

bool same_group_both_ways(const Sonar& sonar, const Scatterer& s) {
  if (s.path == 0) return true;
  const std::optional<int> sent = sector_of(sonar, double{s.departure.azimuth_rad});
  return sent && group_of(sonar, *sent) == group_of(sonar, static_cast<int>(s.beam));
}

bool in_group(const Sonar& sonar, const Scatterer& s, int group) {
  return group_of(sonar, static_cast<int>(s.beam)) == group && same_group_both_ways(sonar, s);
}

namespace {

// Copies the row of each cell to that of its beam.
void copy_rows(const Fan& fan, std::size_t samples, const std::vector<float>& from,
               std::vector<float>& to) {
  for (int cell = 0; cell < fan.beams; ++cell) {
    const auto row = from.begin() + static_cast<std::ptrdiff_t>(cell * samples);
    std::copy(row, row + static_cast<std::ptrdiff_t>(samples),
              to.begin() + static_cast<std::ptrdiff_t>(fan.beam_of(cell) * samples));
  }
}

// Sorts `hidden` by beam and delay.
void sort_hidden(HiddenEchoes& hidden, int beams, const Workers& workers) {
  std::vector<std::uint64_t> key;
  for (Scatterer& s : hidden.list.items) {
    key.push_back(s.key);
    s.key = key.size() - 1;
  }
  hidden.list = sorted_by_beam_and_delay(hidden.list.items, beams, workers);
  std::vector<std::uint32_t> occluder;
  for (Scatterer& s : hidden.list.items) {
    occluder.push_back(hidden.occluder[s.key]);
    s.key = key[s.key];
  }
  hidden.occluder = std::move(occluder);
}

}  // namespace

void GroupEchoes::add(const Fan& fan, PingEchoes part) {
  const auto append_to = [](auto& all, const auto& more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  append_to(all_.scatterers.items, part.scatterers.items);
  if (all_.volumes.empty()) {
    const std::vector<float> silent(std::size_t(sonar_.beam_count) * samples_, 0.0f);
    for (const VolumeEcho& volume : part.volumes) {
      all_.volumes.push_back({volume.instance, silent, silent, silent});
    }
  }
  for (std::size_t v = 0; v < part.volumes.size(); ++v) {
    for (const auto row :
         {&VolumeEcho::energy, &VolumeEcho::elevation_rad, &VolumeEcho::elevation_square}) {
      copy_rows(fan, samples_, part.volumes[v].*row, all_.volumes[v].*row);
    }
  }
  for (ElevationEcho& echo : part.volume_elevation) {
    echo.beam = static_cast<std::uint16_t>(fan.beam_of(echo.beam));
  }
  append_to(all_.volume_elevation, part.volume_elevation);
  append_to(all_.hidden.list.items, part.hidden.list.items);
  append_to(all_.hidden.occluder, part.hidden.occluder);
  occluded_.resize(part.hidden.occlusion.size());
  counted_.resize(part.hidden.occlusion.size());
  for (std::size_t i = 0; i < occluded_.size(); ++i) {
    if (std::isnan(part.hidden.occlusion[i])) continue;
    occluded_[i] += part.hidden.occlusion[i];
    ++counted_[i];
  }
}

PingEchoes GroupEchoes::joined(const Workers& workers) && {
  all_.scatterers = sorted_by_beam_and_delay(all_.scatterers.items, sonar_.beam_count, workers);
  sort_hidden(all_.hidden, sonar_.beam_count, workers);
  for (std::size_t i = 0; i < occluded_.size(); ++i) {
    all_.hidden.occlusion.push_back(counted_[i] > 0 ? occluded_[i] / counted_[i]
                                                    : std::numeric_limits<double>::quiet_NaN());
  }
  std::ranges::stable_sort(all_.volume_elevation, {}, &ElevationEcho::beam);
  return std::move(all_);
}

}  // namespace ensonify
