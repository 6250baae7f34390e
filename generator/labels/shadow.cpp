#include "labels/shadow.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"
#include "labels/cartesian.h"
#include "labels/sector_echoes.h"

namespace ensonify {
namespace {

// Beams in a block, so that long stretches of an image's rows are written at once.
constexpr int kShadowBlockBeams = 32;

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
  std::vector<std::vector<std::uint16_t>> take() { return std::move(sets_); }

 private:
  std::vector<std::vector<std::uint16_t>> sets_{{}};
  std::map<std::vector<std::uint16_t>, std::uint32_t> numbers_{{{}, 0}};
  std::uint32_t last_ = 0;
};

// The labels of a block of beams, beam by beam.
struct BlockLabels {
  std::vector<std::uint16_t> shadow;
  std::vector<std::uint32_t> set;
  SetTable sets;
};

// Labels the pixels of one beam.
class BeamLabeller {
 public:
  BeamLabeller(const HiddenInput& input, const LabelledImage& image)
      : input_(input), image_(image), has_noise_(input.heard.noise_power_pa2 > 0) {}

  void label(int beam, std::uint16_t* shadow, std::uint32_t* set, SetTable& sets) {
    const PolarInput& heard_input = input_.heard;
    const HiddenEchoes& hidden_input = input_.hidden;
    gather_sector(*heard_input.scatterers, {}, beam, heard_input.bandwidth_hz, heard_);
    gather_sector(hidden_input.list, hidden_input.occluder, beam, heard_input.bandwidth_hz,
                  hidden_);
    for (auto* echoes : {&heard_, &hidden_}) std::erase_if(*echoes, is_bounced);
    EchoWindow heard_window(heard_), hidden_window(hidden_);
    for (int n = 0; n < heard_input.samples; ++n) {
      const auto heard = heard_window.at(n), hidden = hidden_window.at(n);
      if (heard.empty() && hidden.empty() && heard_input.volumes.empty()) {
        n = std::max(n, std::min(heard_window.silent_until(heard_input.samples),
                                 hidden_window.silent_until(heard_input.samples)));
        continue;
      }
      shadow[n] = static_cast<std::uint16_t>(occluder_of(beam, n, heard, hidden));
      set[n] = amodal_set(beam, n, heard, hidden, sets);
    }
  }

 private:
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

  std::uint32_t amodal_set(int beam, int sample, std::span<const SectorEcho> heard,
                           std::span<const SectorEcho> hidden, SetTable& sets) {
    const std::uint16_t own = image_.instance[std::size_t(sample) * image_.columns + beam];
    const auto is_own = [own](const SectorEcho& echo) { return echo.instance == own; };
    shares_.clear();
    // Most pixels hold only echoes of their own instance, whose power does not matter.
    if (!std::ranges::all_of(hidden, is_own) || !std::ranges::all_of(heard, is_own)) {
      for (const auto& echoes : {heard, hidden}) {
        for (const SectorEcho& echo : echoes) {
          add_share(echo.instance, echo.energy, power_of(echo, sample), shares_);
        }
      }
    }
    instances_.clear();
    if (own != 0) instances_.push_back(own);
    for (const EnergyShare& share : shares_) {
      if (share.instance == own || is_under_noise(beam, share.power)) continue;
      instances_.push_back(static_cast<std::uint16_t>(share.instance));
    }
    std::sort(instances_.begin(), instances_.end());
    return sets.number_of(instances_);
  }

  const HiddenInput& input_;
  const LabelledImage& image_;
  bool has_noise_;
  std::vector<SectorEcho> heard_, hidden_;
  std::vector<EnergyShare> shares_;
  std::vector<std::uint16_t> instances_;
};

// Labels blocks of beams and puts them into images whose rows are samples.
class HiddenLabeller {
 public:
  HiddenLabeller(const HiddenInput& input, const LabelledImage& image)
      : input_(input), image_(image), beams_(input.heard.beams), samples_(input.heard.samples) {
    const std::size_t count = std::size_t(beams_) * samples_;
    labels_.shadow.resize(count);
    labels_.amodal.rows = samples_;
    labels_.amodal.columns = beams_;
    labels_.amodal.set.resize(count);
    labels_.amodal.stride = static_cast<std::uint32_t>(kShadowBlockBeams * samples_ + 1);
    sets_.resize(blocks());
  }

  std::size_t blocks() const {
    return static_cast<std::size_t>((beams_ + kShadowBlockBeams - 1) / kShadowBlockBeams);
  }

  void label(std::size_t block) {
    const int first = static_cast<int>(block) * kShadowBlockBeams;
    const int count = std::min(kShadowBlockBeams, beams_ - first);
    BlockLabels own;
    own.shadow.resize(std::size_t(count) * samples_);
    own.set.resize(own.shadow.size());
    BeamLabeller beam(input_, image_);
    for (int j = 0; j < count; ++j) {
      const std::size_t row = std::size_t(j) * samples_;
      beam.label(first + j, own.shadow.data() + row, own.set.data() + row, own.sets);
    }
    const auto base = static_cast<std::uint32_t>(block) * labels_.amodal.stride;
    for (std::uint32_t& set : own.set) set = set == 0 ? 0 : base + set;
    put_block(own.shadow, first, count, labels_.shadow);
    put_block(own.set, first, count, labels_.amodal.set);
    sets_[block] = own.sets.take();
  }

  HiddenLabels take() {
    labels_.amodal.of_block = std::make_shared<const InstanceSets::Tables>(std::move(sets_));
    return std::move(labels_);
  }

 private:
  // Writes consecutive columns into the image's rows.
  template <class T>
  void put_block(const std::vector<T>& columns, int first, int count, std::vector<T>& image) const {
    for (int n = 0; n < samples_; ++n) {
      const T* from = columns.data() + n;
      T* to = image.data() + std::size_t(n) * beams_ + first;
      if (count == kShadowBlockBeams) {
        // With a constant count the compiler uses a few wide stores instead of a loop.
        for (int j = 0; j < kShadowBlockBeams; ++j) to[j] = from[std::size_t(j) * samples_];
      } else {
        for (int j = 0; j < count; ++j) to[j] = from[std::size_t(j) * samples_];
      }
    }
  }

  const HiddenInput& input_;
  const LabelledImage& image_;
  int beams_, samples_;
  HiddenLabels labels_;
  InstanceSets::Tables sets_;
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
  HiddenLabeller labeller(input, image);
  workers.for_each(labeller.blocks(), [&](std::size_t block) { labeller.label(block); });
  return labeller.take();
}

InstanceSets resample(const InstanceSets& polar, const CartesianGrid& grid,
                      const std::vector<std::int32_t>& map) {
  return {grid.height_px, grid.width_px, resampled(polar.set, grid, map), polar.stride,
          polar.of_block};
}

}  // namespace ensonify
