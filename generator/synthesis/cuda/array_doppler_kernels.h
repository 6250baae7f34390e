// What one thread of a device does for shifted echoes at an array; as doppler_kernels.h. Their
// sounds, once weighed, are placed and gathered as those at rest.
//
//   HearShifts   copies the shifted sounds, and leaves their share at rest behind
//   WeighSounds  what they give to a node
#pragma once

#include "synthesis/cuda/array_kernels.h"
#include "synthesis/cuda/doppler_kernels.h"

namespace ensonify {

// After HearEchoes.
struct HearShifts {
  const ShiftRecord* shifts;
  const EchoRecord* echoes;
  DeviceNodes nodes;
  double points_per_s;  // of the nodes' grids
  Sound* at_rest;       // [echoes]
  Complex32* value;     // [shifts], and so on
  NodePlace* place;
  Sound* out;  // without its value

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const ShiftRecord& shift = shifts[i];
    Sound& sound = at_rest[shift.echo];
    place[i] = node_place(nodes, shift.doppler);
    value[i] = sound.value;
    out[i] = sound;
    out[i].points = echoes[shift.echo].delay_s * points_per_s;
    sound.value = scaled(node_weight(nodes, place[i], 0), value[i]);
  }
};

struct WeighSounds {
  const Complex32* value;
  const NodePlace* place;
  DeviceNodes nodes;
  int node;
  Sound* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    out[i].value = scaled(node_weight(nodes, place[i], node), value[i]);
  }
};

}  // namespace ensonify
