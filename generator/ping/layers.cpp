#include "ping/layers.h"

#include <algorithm>
#include <string_view>

namespace ensonify {
namespace {

bool encloses_or_has_no_end(const ShapeSpec& shape) {
  if (const auto* box = std::get_if<BoxSpec>(&shape)) return box->inside;
  if (const auto* sphere = std::get_if<SphereSpec>(&shape)) return sphere->inside;
  return std::holds_alternative<PlaneSpec>(shape) || std::holds_alternative<HeightfieldSpec>(shape);
}

// Whether `name` is a copy of the entry `base`, which has a count.
bool is_counted(std::string_view name, std::string_view base) {
  if (!name.starts_with(base) || name.size() < base.size() + 2 || name[base.size()] != '_') {
    return false;
  }
  return name.substr(base.size() + 1).find_first_not_of("0123456789") == std::string_view::npos;
}

struct Candidate {
  std::string_view name, class_name;
  bool by_default = true;
};

// In the order of the instance ids.
std::vector<Candidate> candidates_of(const Scenario& scenario) {
  std::vector<Candidate> candidates;
  for (const ObjectSpec& object : scenario.objects) {
    candidates.push_back({object.name, object.class_name, !encloses_or_has_no_end(object.shape)});
  }
  for (const PointTargetSpec& target : scenario.point_targets) {
    candidates.push_back({target.name, target.class_name});
  }
  return candidates;
}

}  // namespace

std::vector<std::uint16_t> target_instances(const Scenario& scenario) {
  const std::vector<Candidate> candidates = candidates_of(scenario);
  const auto& words = scenario.output.layer_targets;
  std::vector<bool> chosen(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!words) chosen[i] = candidates[i].by_default;
  }
  for (const std::string& word : words.value_or(std::vector<std::string>())) {
    const bool is_name = std::any_of(candidates.begin(), candidates.end(),
                                     [&](const Candidate& c) { return c.name == word; });
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const Candidate& c = candidates[i];
      const bool meant =
          c.name == word || c.class_name == word || (!is_name && is_counted(c.name, word));
      if (meant) chosen[i] = true;
    }
  }
  std::vector<std::uint16_t> ids;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i]) ids.push_back(static_cast<std::uint16_t>(i + 1));
  }
  return ids;
}

std::vector<Layer> layer_table(const SequenceInfo& info) {
  std::vector<Layer> table(info.instances.size() + 1, Layer::background);
  for (const Instance& instance : info.instances) {
    if (instance.kind == InstanceKind::volume) table[instance.id] = Layer::volume;
  }
  for (const std::uint16_t id : info.target_instances) table[id] = Layer::target;
  return table;
}

std::vector<Layer> layers_of(const SequenceInfo& info) {
  const std::vector<Layer> table = layer_table(info);
  const auto holds = [&](Layer layer) {
    return std::find(table.begin() + 1, table.end(), layer) != table.end();
  };
  std::vector<Layer> layers;
  if (info.noise_spectrum_level_db || info.noise_snr_db) layers.push_back(Layer::noise);
  for (const Layer layer : {Layer::volume, Layer::target, Layer::background}) {
    if (holds(layer)) layers.push_back(layer);
  }
  if (!info.paths.empty()) layers.push_back(Layer::multipath);
  if (info.sonar.front_end) {
    layers.push_back(Layer::electronics);
  } else if (info.sonar.adc) {
    layers.push_back(Layer::quantisation);
  }
  return layers;
}

ScattererList scatterers_of(Layer layer, const std::vector<Layer>& table,
                            const ScattererList& all) {
  ScattererList part;
  part.beam_offset.assign(all.beam_offset.size(), 0);
  for (std::size_t beam = 0; beam + 1 < all.beam_offset.size(); ++beam) {
    for (std::size_t i = all.beam_offset[beam]; i < all.beam_offset[beam + 1]; ++i) {
      const Scatterer& s = all.items[i];
      if ((s.path != 0 ? Layer::multipath : table[s.instance]) == layer) part.items.push_back(s);
    }
    part.beam_offset[beam + 1] = static_cast<std::uint32_t>(part.items.size());
  }
  return part;
}

Series remainder(std::span<const std::complex<float>> whole, std::span<const LayerSeries> layers) {
  Series rest(whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::complex<double> left = whole[i];
    for (const LayerSeries& layer : layers) left -= std::complex<double>(layer.pressure_pa[i]);
    rest[i] = std::complex<float>(left);
  }
  return rest;
}

void settle(std::span<const std::complex<float>> whole, std::span<LayerSeries> layers) {
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::complex<double> left = whole[i];
    std::complex<float>* strongest = nullptr;
    for (LayerSeries& layer : layers) {
      std::complex<float>& p = layer.pressure_pa[i];
      left -= std::complex<double>(p);
      if (layer.layer == Layer::noise) continue;
      if (strongest == nullptr || std::norm(p) > std::norm(*strongest)) strongest = &p;
    }
    if (strongest != nullptr)
      *strongest = std::complex<float>(std::complex<double>(*strongest) + left);
  }
}

}  // namespace ensonify
