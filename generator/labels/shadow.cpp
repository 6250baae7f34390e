#include "labels/shadow.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"
#include "labels/sector_echoes.h"

namespace ensonify {
namespace {

// Labels are found along samples and lie along beams. A block is one cache line wide, and its part
// of some samples stays in the first-level cache.
constexpr int kShadowBlockBeams = 32, kShadowBlockSamples = 128;

bool is_bounced(const SectorEcho& echo) { return echo.bounced; }

// The sets of a block and their numbers; 0 is the empty set.
class SetTable {
 public:
  // `sorted` by id.
  std::uint32_t number_of(const std::vector<std::uint16_t>& sorted) {
    if (sorted == sets_[last_]) return last_;
    const auto [found, is_new] =
        numbers_.try_emplace(sorted, static_cast<std::uint32_t>(sets_.size()));
    if (is_new) sets_.push_back(sorted);
    return last_ = found->second;
  }
  // Of a single instance, or of none.
  std::uint32_t number_of(std::uint16_t id) {
    if (id == 0) return 0;
    if (id != single_) {
      single_ = id;
      number_of_single_ = number_of(std::vector{id});
    }
    return number_of_single_;
  }
  std::vector<std::vector<std::uint16_t>> take() { return std::move(sets_); }

 private:
  std::vector<std::vector<std::uint16_t>> sets_{{}};
  std::map<std::vector<std::uint16_t>, std::uint32_t> numbers_{{{}, 0}};
  std::uint32_t last_ = 0;
  std::uint16_t single_ = 0;  // the instance that was asked for last
  std::uint32_t number_of_single_ = 0;
};

// Labels a block of beams.
class BlockLabeller {
 public:
  BlockLabeller(const HiddenInput& input, const LabelledImage& image, int first, int count)
      : input_(input),
        image_(image),
        has_noise_(input.heard.noise_power_pa2 > 0),
        first_(first),
        heard_(static_cast<std::size_t>(count)),
        hidden_(heard_.size()) {
    for (std::size_t j = 0; j < heard_.size(); ++j) {
      const std::size_t beam = static_cast<std::size_t>(first) + j;
      gather_sector(*input.heard.scatterers, {}, beam, input.heard.bandwidth_hz, heard_[j]);
      gather_sector(input.hidden.list, input.hidden.occluder, beam, input.heard.bandwidth_hz,
                    hidden_[j]);
      for (auto* echoes : {&heard_[j], &hidden_[j]}) std::erase_if(*echoes, is_bounced);
    }
  }

  // `base`: the number of the block's empty set.
  void label(std::uint32_t base, HiddenLabels& labels) {
    for (int sample = 0; sample < input_.heard.samples; sample += kShadowBlockSamples) {
      const int end = std::min(sample + kShadowBlockSamples, input_.heard.samples);
      for (std::size_t j = 0; j < heard_.size(); ++j) label_beam(j, sample, end, base, labels);
    }
  }
  std::vector<std::vector<std::uint16_t>> take_sets() { return sets_.take(); }

 private:
  void label_beam(std::size_t j, int first_sample, int end, std::uint32_t base,
                  HiddenLabels& labels) {
    EchoWindow heard_window(heard_[j], first_sample), hidden_window(hidden_[j], first_sample);
    const int beam = first_ + static_cast<int>(j);
    for (int n = first_sample; n < end; ++n) {
      const auto heard = heard_window.at(n), hidden = hidden_window.at(n);
      if (heard.empty() && hidden.empty() && input_.heard.volumes.empty()) {
        n = std::max(n, std::min(heard_window.silent_until(end), hidden_window.silent_until(end)));
        continue;
      }
      const std::size_t pixel = std::size_t(n) * image_.columns + beam;
      labels.shadow[pixel] = static_cast<std::uint16_t>(occluder_of(beam, n, heard, hidden));
      const std::uint32_t set = amodal_set(image_.instance[pixel], beam, n, heard, hidden);
      labels.amodal.set[pixel] = set == 0 ? 0 : base + set;
    }
  }

  double power_of(const SectorEcho& echo, int sample) const {
    if (!has_noise_) return 0;
    const double step =
        std::clamp((sample - echo.sample + 1.0) * (kPulseSteps / 2.0), 0.0, double{kPulseSteps});
    const int below = static_cast<int>(step);
    return echo.energy * input_.pulse_power[below + (step - below >= 0.5)];
  }

  bool is_under_noise(int beam, double power) const {
    return has_noise_ && power * input_.power_per_energy[beam] < input_.heard.noise_power_pa2;
  }

  double volume_energy(int beam, int sample) const {
    double sum = 0;
    for_each_cell_beside(beam, sample, input_.heard.samples, [&](std::size_t cell, double weight) {
      sum += total_energy(input_.heard.volumes, cell) * weight;
    });
    return sum;
  }

  std::uint32_t occluder_of(int beam, int sample, std::span<const SectorEcho> heard,
                            std::span<const SectorEcho> hidden) {
    shares_.clear();
    double energy = 0, power = 0;
    for (const SectorEcho& echo : hidden) {
      if (echo.occluder == 0) continue;
      energy += echo.energy;
      power += power_of(echo, sample);
      add_share(echo.occluder, echo.energy, 0, shares_);
    }
    if (shares_.empty() || is_under_noise(beam, power)) return 0;
    double heard_energy = input_.heard.volumes.empty() ? 0 : volume_energy(beam, sample);
    for (const SectorEcho& echo : heard) heard_energy += echo.energy;
    if (!(energy > heard_energy)) return 0;
    return strongest(shares_).instance;
  }

  std::uint32_t amodal_set(std::uint16_t own, int beam, int sample,
                           std::span<const SectorEcho> heard, std::span<const SectorEcho> hidden) {
    const auto is_own = [own](const SectorEcho& echo) { return echo.instance == own; };
    // Most pixels hold only echoes of their own instance, whose power does not matter.
    if (std::ranges::all_of(hidden, is_own) && std::ranges::all_of(heard, is_own)) {
      return sets_.number_of(own);
    }
    shares_.clear();
    for (const auto& echoes : {heard, hidden}) {
      for (const SectorEcho& echo : echoes) {
        add_share(echo.instance, echo.energy, power_of(echo, sample), shares_);
      }
    }
    instances_.clear();
    if (own != 0) instances_.push_back(own);
    for (const EnergyShare& share : shares_) {
      if (share.instance == own || is_under_noise(beam, share.power)) continue;
      instances_.push_back(static_cast<std::uint16_t>(share.instance));
    }
    std::sort(instances_.begin(), instances_.end());
    return sets_.number_of(instances_);
  }

  const HiddenInput& input_;
  const LabelledImage& image_;
  bool has_noise_;
  int first_;
  std::vector<std::vector<SectorEcho>> heard_, hidden_;  // by beam
  SetTable sets_;
  std::vector<EnergyShare> shares_;
  std::vector<std::uint16_t> instances_;
};

}  // namespace

HiddenLabels hidden_labels(const HiddenInput& input, const LabelledImage& image,
                           const Workers& workers) {
  const PolarInput& heard = input.heard;
  ENSONIFY_ASSERT(image.rows == heard.samples && image.columns == heard.beams);
  ENSONIFY_ASSERT(input.hidden.occluder.size() == input.hidden.list.size());
  if (heard.noise_power_pa2 > 0) {
    ENSONIFY_ASSERT(input.pulse_power.size() == kPulseSteps + 1 &&
                    input.power_per_energy.size() == static_cast<std::size_t>(heard.beams));
  }
  const std::size_t count = std::size_t(heard.beams) * heard.samples;
  HiddenLabels labels;
  labels.shadow.resize(count);
  labels.amodal.rows = heard.samples;
  labels.amodal.columns = heard.beams;
  labels.amodal.set.resize(count);
  labels.amodal.stride = static_cast<std::uint32_t>(kShadowBlockBeams * heard.samples + 1);
  InstanceSets::Tables sets((static_cast<std::size_t>(heard.beams) + kShadowBlockBeams - 1) /
                            kShadowBlockBeams);
  workers.for_each(sets.size(), [&](std::size_t block) {
    const int first = static_cast<int>(block) * kShadowBlockBeams;
    BlockLabeller labeller(input, image, first, std::min(kShadowBlockBeams, heard.beams - first));
    labeller.label(static_cast<std::uint32_t>(block) * labels.amodal.stride, labels);
    sets[block] = labeller.take_sets();
  });
  labels.amodal.of_block = std::make_shared<const InstanceSets::Tables>(std::move(sets));
  return labels;
}

}  // namespace ensonify
