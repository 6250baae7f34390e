// The signal components (layers) that add up to the time series (core/ping.h).
//
//   target_instances  the instances that belong to `target`
//   layers_of         which layers a sequence has
//   layer_table       the layer of each instance
//   scatterers_of     the scatterers of one layer
//   remainder         the difference of the whole and the layers
//   settle            adds the remainder to a layer
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/ping.h"
#include "core/scatterers.h"
#include "scenario/scenario.h"

namespace ensonify {

// Ids in ascending order. A word of output.layers.targets is the name of an object or point target,
// a class, or the name of an entry with a count. Without words, all instances except planes, height
// fields and inward-facing shapes.
std::vector<std::uint16_t> target_instances(const Scenario& scenario);

// Layers in the order of the enumeration, without those that are empty in all pings of the
// sequence. `info` needs the instances, noise, ADC and target_instances.
std::vector<Layer> layers_of(const SequenceInfo& info);

// For each of [instances + 1]: `target`, `background` or `volume`, the layer with the direct echoes
// of the instance; entry 0 is not used.
std::vector<Layer> layer_table(const SequenceInfo& info);

ScattererList scatterers_of(Layer layer, const std::vector<Layer>& table, const ScattererList& all);

// whole - sum of the layers, summed in double precision.
Series remainder(std::span<const std::complex<float>> whole, std::span<const LayerSeries> layers);

// Adds the remainder, sample by sample, to the strongest existing layer except noise. A backend's
// plan is the same for every layer and its sums are linear, so the remainder is a rounding error.
// It is far below the tolerance, but exceeds float rounding if beams are sums of nodes that cancel.
void settle(std::span<const std::complex<float>> whole, std::span<LayerSeries> layers);

}  // namespace ensonify
