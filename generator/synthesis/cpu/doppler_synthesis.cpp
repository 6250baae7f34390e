#include "synthesis/cpu/doppler_synthesis.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include "synthesis/cpu/doppler_nodes.h"
#include "synthesis/cpu/ping_synthesis.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// The tolerance for the mean, which is the same as for the time series because they share nodes.
// The expected power has the square of the mean and thus twice its relative error.
constexpr double kMeanTolerance = 3e-5;

// The memory of one ping in work, in addition to that of its nodes.
struct DopplerScratch {
  std::vector<Complex> sum, mean;  // [beams x samples]
  std::vector<Complex> channels;   // [elements x samples], if requested
  ScattererList part;
  PingSeries series;
};

bool is_shifted(const Scatterer& s) { return s.doppler != 0; }
bool is_diffuse(const Scatterer& s) { return s.standard_deviation != 0; }
bool has_mean(const Scatterer& s) { return s.mean != 0.0f; }

// Calls change(scatterer) for copies of all scatterers of `list`, and puts those for which it
// returns true `into` a list, as changed.
template <class Change>
void select(const ScattererList& list, ScattererList& into, const Change& change) {
  into.items.clear();
  into.beam_offset.assign(1, 0);
  for (std::size_t beam = 0; beam + 1 < list.beam_offset.size(); ++beam) {
    for (std::size_t i = list.beam_offset[beam]; i < list.beam_offset[beam + 1]; ++i) {
      Scatterer s = list.items[i];
      if (change(s)) into.items.push_back(s);
    }
    into.beam_offset.push_back(static_cast<std::uint32_t>(into.items.size()));
  }
}

void add(std::span<const std::complex<float>> series, std::vector<Complex>& sum) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += Complex(series[i]);
}

class DopplerSynthesis final : public PingSynthesis {
 public:
  DopplerSynthesis(SynthesisTables tables, MakeSynthesis make, NodeSpectra spectra)
      : tables_(std::move(tables)),
        make_(std::move(make)),
        spectra_(std::move(spectra)),
        weigher_(spectra_.nodes()),
        unshifted_(make_(tables_)) {}

  SynthesisMemory memory(bool has_volumes) const override;

  void run(const PingTask& task, PingSeries& result, const Workers& workers) const override {
    const auto& items = task.scatterers->items;
    if (std::none_of(items.begin(), items.end(), is_shifted)) {
      return unshifted_->run(task, result, workers);
    }
    if (unshifted_->run_shifted(task, spectra_, result, workers)) return;
    auto scratch = pool_.take();
    add_nodes(task, *scratch, workers);
    if (task.wants_clean) diffuse_power(task, *scratch, result, workers);
    result.pressure_pa.assign(scratch->sum.begin(), scratch->sum.end());
    result.channels_pa.assign(scratch->channels.begin(), scratch->channels.end());
    if (!task.wants_clean) {
      result.clean_power_pa2.clear();
      return;
    }
    for (std::size_t i = 0; i < scratch->mean.size(); ++i) {
      result.clean_power_pa2[i] += static_cast<float>(std::norm(scratch->mean[i]));
    }
  }

 private:
  std::size_t cells() const {
    return std::size_t(tables_.setup.sonar.beam_count) * tables_.setup.record.samples;
  }
  std::size_t channel_cells() const {
    const auto& array = tables_.setup.sonar.array;
    return array ? std::size_t(array->elements) * tables_.setup.record.samples : 0;
  }
  const PingSynthesis* at_node(int node) const;
  void add_nodes(const PingTask& task, DopplerScratch& scratch, const Workers& workers) const;
  void add_node(const PingTask& task, int node, DopplerScratch& scratch,
                const Workers& workers) const;
  void diffuse_power(const PingTask& task, DopplerScratch& scratch, PingSeries& result,
                     const Workers& workers) const;

  SynthesisTables tables_;
  MakeSynthesis make_;
  NodeSpectra spectra_;
  DopplerWeigher weigher_;
  std::unique_ptr<PingSynthesis> unshifted_;
  mutable std::mutex mutex_;
  mutable std::map<int, std::unique_ptr<PingSynthesis>> made_;
  mutable Pool<DopplerScratch> pool_;
};

SynthesisMemory DopplerSynthesis::memory(bool has_volumes) const {
  const SynthesisSetup& setup = tables_.setup;
  const double width = spectra_.nodes().width;
  const double bands = std::ceil(setup.max_doppler / width) - std::floor(setup.min_doppler / width);
  // The node at rest always exists.
  const auto copies = static_cast<std::uint64_t>(2 + spectra_.nodes().degree * bands);
  if (const auto own = unshifted_->shifted_memory(has_volumes, copies)) return *own;
  SynthesisMemory memory = unshifted_->memory(has_volumes);
  // Each node has its own tables and scratch memory.
  memory.shared_bytes *= copies;
  memory.ping_bytes *= copies;
  memory.echo_bytes *= copies;
  memory.thread_bytes *= copies;
  memory.ping_bytes += channel_cells() * (sizeof(Complex) + sizeof(std::complex<float>));
  memory.ping_bytes += cells() * (2 * sizeof(Complex) + sizeof(std::complex<float>));
  memory.echo_bytes += sizeof(Scatterer);
  return memory;
}

// Null if the pulse is outside of the band.
const PingSynthesis* DopplerSynthesis::at_node(int node) const {
  if (node == 0) return unshifted_.get();
  const std::lock_guard lock(mutex_);
  const auto [entry, is_new] = made_.try_emplace(node);
  if (is_new) {
    SynthesisTables tables = tables_;
    tables.spectrum = spectra_.at(node);
    if (!tables.spectrum.empty()) entry->second = make_(tables);
  }
  return entry->second.get();
}

void DopplerSynthesis::add_nodes(const PingTask& task, DopplerScratch& scratch,
                                 const Workers& workers) const {
  scratch.sum.assign(cells(), 0);
  scratch.mean.assign(task.wants_clean ? cells() : 0, 0);
  scratch.channels.assign(task.wants_channels ? channel_cells() : 0, 0);
  std::set<int> needed = {0};  // node 0 also has noise and volumes
  double value[DopplerNodes::kMostDegree + 1];
  for (const Scatterer& s : task.scatterers->items) {
    if (s.doppler == 0) continue;
    const auto [first, step] = weigher_.weigh(static_cast<double>(s.doppler), value);
    for (int q = 0; q <= weigher_.degree(); ++q) {
      if (value[q] != 0) needed.insert(first + step * q);
    }
  }
  for (const int node : needed) add_node(task, node, scratch, workers);
}

void DopplerSynthesis::add_node(const PingTask& task, int node, DopplerScratch& scratch,
                                const Workers& workers) const {
  const PingSynthesis* synthesis = at_node(node);
  if (synthesis == nullptr) return;
  const auto weigh = [&](Scatterer& s) {
    double value[DopplerNodes::kMostDegree + 1];
    const auto [first, step] = weigher_.weigh(static_cast<double>(s.doppler), value);
    const int q = step * (node - first);
    if (q < 0 || q > weigher_.degree() || value[q] == 0) return false;
    s.gain = static_cast<float>(s.gain * value[q]);
    return true;
  };
  select(*task.scatterers, scratch.part, weigh);
  PingTask part{&scratch.part, task.keys, 0, {}, false, task.wants_channels};
  if (node == 0) {
    part.noise_power_pa2 = task.noise_power_pa2;
    part.volumes = task.volumes;
  }
  synthesis->run(part, scratch.series, workers);
  add(scratch.series.pressure_pa, scratch.sum);
  if (task.wants_channels) add(scratch.series.channels_pa, scratch.channels);
  const auto& items = scratch.part.items;
  if (!task.wants_clean || std::none_of(items.begin(), items.end(), has_mean)) return;
  // Without diffuse parts, noise and volumes, the time series is the mean.
  if (node == 0 || std::any_of(items.begin(), items.end(), is_diffuse)) {
    select(*task.scatterers, scratch.part, [&](Scatterer& s) {
      s.standard_deviation = 0;
      return has_mean(s) && weigh(s);
    });
    synthesis->run({&scratch.part, task.keys, 0, {}, false}, scratch.series, workers);
  }
  add(scratch.series.pressure_pa, scratch.mean);
}

// Doppler changes the phase of an echo within its pulse and hardly stretches its envelope.
// Therefore |s|^2 is that of the pulse at rest.
void DopplerSynthesis::diffuse_power(const PingTask& task, DopplerScratch& scratch,
                                     PingSeries& result, const Workers& workers) const {
  select(*task.scatterers, scratch.part, [](Scatterer& s) {
    s.mean = 0;
    s.doppler = 0;
    return is_diffuse(s);
  });
  if (scratch.part.items.empty() && task.volumes.empty()) {
    result.clean_power_pa2.assign(cells(), 0.0f);
    return;
  }
  unshifted_->run({&scratch.part, task.keys, 0, task.volumes, true}, result, workers);
}

}  // namespace

std::unique_ptr<PingSynthesis> make_doppler_synthesis(const SynthesisTables& tables,
                                                      MakeSynthesis make) {
  SynthesisTables finer = tables;
  finer.setup.tolerance = std::min(tables.setup.tolerance, kMeanTolerance);
  DopplerPulse pulse = make_doppler_pulse(tables.setup.sonar, tables.setup.record.transform);
  const DopplerNodes nodes = choose_doppler_nodes(pulse, finer.setup.tolerance);
  if (nodes.degree == 0) return nullptr;
  return std::make_unique<DopplerSynthesis>(std::move(finer), std::move(make),
                                            NodeSpectra(std::move(pulse), nodes));
}

}  // namespace ensonify
