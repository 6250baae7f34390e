// The echoes of groups of beams that transmit in turn (Sonar::transmit).
//
//   keep_if          some scatterers of a list
//   with_all_beams   numbers the cells of a group's fan as beams of the sonar
//   points_of_cells  the reverse
//   in_group  same_group_both_ways   which group an echo belongs to
//   GroupEchoes      joins the echoes of all groups
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "core/sonar.h"
#include "ping/moment.h"
#include "trace/hits.h"
#include "trace/scatter.h"

namespace ensonify {

// [beams + 1]: where the scatterers of each beam begin, which are sorted by beam.
std::vector<std::uint32_t> beam_offsets(std::span<const Scatterer> sorted, int beams);

template <class Keep>
void keep_if(ScattererList& list, int beams, Keep&& keep) {
  std::erase_if(list.items, [&](const Scatterer& s) { return !keep(s); });
  list.beam_offset = beam_offsets(list.items, beams);
}

// The scatterers of a fan's cells as those of the `beams` of the sonar. Adds the number of rays in
// cells of other groups to each key, so that keys of rays are those of the whole fan;
// `keys_are_rays` is false if keys are something else.
ScattererList with_all_beams(const Fan& fan, ScattererList list, int beams,
                             bool keys_are_rays = true);
void with_all_beams(const Fan& fan, std::span<Scatterer> scatterers);

// Those in the fan's cells, with the numbers of the cells.
PointScatterers points_of_cells(const Fan& fan, PointScatterers points);

// Whether sound leaves and arrives in beam cells of one group. Direct echoes always do.
bool same_group_both_ways(const Sonar& sonar, const Scatterer& s);
bool in_group(const Sonar& sonar, const Scatterer& s, int group);

class GroupEchoes {
 public:
  GroupEchoes(const Sonar& sonar, int samples) : sonar_(sonar), samples_(samples) {}

  // `part` are the echoes of `fan`, whose volumes have a row for each of its cells.
  void add(const Fan& fan, PingEchoes part);
  PingEchoes joined(const Workers& workers) &&;

 private:
  const Sonar& sonar_;
  int samples_;
  PingEchoes all_;
  std::vector<double> occluded_, counted_;  // by instance: sums over groups
};


}  // namespace ensonify
