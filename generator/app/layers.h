// The layers that a series adds up from (core/ping.h).
//
//   target_instances  who belongs to `target`
//   layers_of         which layers a sequence has
//   layer_table       the layer of each instance
//   scatterers_of     the scatterers of one layer
//   remainder         what the layers leave of the whole
//   settle            nothing
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/ping.h"
#include "core/scatterers.h"
#include "scenario/scenario.h"

namespace ensonify {

// Ids, ascending. A word of output.layers.targets is the name of an object or point target, a
// class, or the name of an entry with a count. Without words: all but planes, height fields and
// shapes seen from inside.
std::vector<std::uint16_t> target_instances(const Scenario& scenario);

// In the order of the enumeration. A layer that no ping of the sequence can fill is left out. Needs
// the instances, noise, converter and target_instances.
std::vector<Layer> layers_of(const SequenceInfo& info);

// [instances + 1], of `target`, `background` and `volume`, where an instance's direct echoes are;
// entry 0 is not used.
std::vector<Layer> layer_table(const SequenceInfo& info);

ScattererList scatterers_of(Layer layer, const std::vector<Layer>& table, const ScattererList& all);

// whole - sum of the layers, summed in double precision.
std::vector<std::complex<float>> remainder(std::span<const std::complex<float>> whole,
                                           std::span<const LayerSeries> layers);

// Adds the remainder, sample by sample, to the strongest layer there but noise. A backend's plan is
// the same for every layer and its sums are linear, so that the remainder is rounding: far under
// the tolerance, but more than float's where beams are sums of nodes that cancel.
void settle(std::span<const std::complex<float>> whole, std::span<LayerSeries> layers);

}  // namespace ensonify
