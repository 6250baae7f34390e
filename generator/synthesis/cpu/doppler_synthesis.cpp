#include "synthesis/cpu/doppler_synthesis.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/units.h"
#include "synthesis/cpu/ping_synthesis.h"
#include "synthesis/fft.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;
using Spectrum = std::vector<Complex>;

constexpr double kShare = 0.3;         // of the tolerance
constexpr double kTail = 1e-6;         // of the norm; weaker tails have no separate limit
constexpr double kNominalSpan = 1e-3;  // of the Doppler in a ping
constexpr double kMostCost = 1000;     // nodes over this span
constexpr double kWidest = 0.02, kMostNodesPerBin = 8;
constexpr double kStep = 1.2;  // the ratio to which the search for the width goes

// The place of node q in its band, from 0 to 1.
double place_in_band(int q, int degree) { return 0.5 - 0.5 * std::cos(kPi * q / degree); }

double norm_of(const Spectrum& s) {
  double sum = 0;
  for (const Complex& v : s) sum += std::norm(v);
  return std::sqrt(sum);
}

// Measures the error of interpolated pulses.
class Judge {
 public:
  Judge(const DopplerPulse& pulse, double tolerance)
      : pulse_(pulse),
        tolerance_(tolerance),
        norm_(norm_of(doppler_spectrum(pulse, 0))),
        samples_(pulse.transform),
        backward_(pulse.transform, FftDirection::backward) {}

  // Whether the tolerance holds in the bands at three values of Doppler: at rest, where the pulse
  // reaches the edge of the frequency band, and where the edge has cut off a quarter of it.
  bool holds(const DopplerNodes& nodes) {
    const double bandwidths = pulse_.sonar.frequency_hz / pulse_.sonar.bandwidth_hz;
    for (const double shift : {0.0, 0.12, 0.25}) {
      const int first = static_cast<int>(shift / (bandwidths * nodes.width)) * nodes.degree;
      if (!holds(nodes, first, 1) || !holds(nodes, -first, -1)) return false;
    }
    return true;
  }

 private:
  // The same for one band, halfway between nodes, in its middle and at its ends.
  bool holds(const DopplerNodes& nodes, int first, int step) {
    std::vector<Spectrum> at_node;
    std::vector<double> doppler;
    for (int q = 0; q <= nodes.degree; ++q) {
      const double u = place_in_band(q, nodes.degree);
      doppler.push_back(step * (std::abs(first) / nodes.degree + u) * nodes.width);
      at_node.push_back(doppler_spectrum(pulse_, doppler.back()));
    }
    for (const int q : {0, nodes.degree / 2, nodes.degree - 1}) {
      const double between = (doppler[q] + doppler[q + 1]) / 2;
      const DopplerWeights weights = weights_at(nodes, between);
      const Spectrum exact = doppler_spectrum(pulse_, between);
      Spectrum error = exact;
      for (int k = 0; k <= nodes.degree; ++k) {
        for (std::size_t m = 0; m < error.size(); ++m) error[m] -= weights.value[k] * at_node[k][m];
      }
      if (norm_of(error) > kShare * tolerance_ * norm_ || !tails_hold(error, exact)) return false;
    }
    return true;
  }

  bool tails_hold(const Spectrum& error, const Spectrum& exact) {
    const std::vector<double> wrong = tails_of(error), right = tails_of(exact);
    for (std::size_t i = 0; i < wrong.size(); ++i) {
      const double scale = std::max(right[i], kTail * kTail * right[0]);
      if (wrong[i] > 100 * tolerance_ * tolerance_ * scale) return false;
    }
    return true;
  }

  // The energy of the samples at a distance of at least x from the middle, for x = 0, 1, 2, 4, ...
  std::vector<double> tails_of(const Spectrum& spectrum) {
    const int count = static_cast<int>(spectrum.size());
    std::copy(spectrum.begin(), spectrum.end(), samples_.begin());
    backward_.run(samples_.data());
    std::vector<double> tails;
    for (int x = 0; x < count / 2; x = x == 0 ? 1 : 2 * x) {
      double sum = 0;
      for (int n = x; n <= count - x && n < count; ++n) sum += std::norm(samples_[n]);
      tails.push_back(sum);
    }
    return tails;
  }

  const DopplerPulse& pulse_;
  double tolerance_, norm_;
  AlignedBuffer<Complex> samples_;
  ComplexFft backward_;
};

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

void add(const std::vector<std::complex<float>>& series, std::vector<Complex>& sum) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += Complex(series[i]);
}

class DopplerSynthesis final : public PingSynthesis {
 public:
  DopplerSynthesis(SynthesisTables tables, MakeSynthesis make, DopplerPulse pulse,
                   DopplerNodes nodes)
      : tables_(std::move(tables)),
        make_(std::move(make)),
        pulse_(std::move(pulse)),
        nodes_(nodes),
        loudest_(largest_magnitude(tables_.spectrum)),
        unshifted_(make_(tables_)) {}

  SynthesisMemory memory(bool has_volumes) const override;

  void run(const PingTask& task, PingSeries& result, const Workers& workers) const override {
    const auto& items = task.scatterers->items;
    if (std::none_of(items.begin(), items.end(), is_shifted)) {
      return unshifted_->run(task, result, workers);
    }
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
  DopplerPulse pulse_;
  DopplerNodes nodes_;
  double loudest_;
  std::unique_ptr<PingSynthesis> unshifted_;
  mutable std::mutex mutex_;
  mutable std::map<int, std::unique_ptr<PingSynthesis>> made_;
  mutable Pool<DopplerScratch> pool_;
};

SynthesisMemory DopplerSynthesis::memory(bool has_volumes) const {
  SynthesisMemory memory = unshifted_->memory(has_volumes);
  const SynthesisSetup& setup = tables_.setup;
  const double bands =
      std::ceil(setup.max_doppler / nodes_.width) - std::floor(setup.min_doppler / nodes_.width);
  // The node at rest always exists.
  const auto copies = static_cast<std::uint64_t>(2 + nodes_.degree * bands);
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
    tables.spectrum = doppler_spectrum(pulse_, node_doppler(nodes_, node));
    if (largest_magnitude(tables.spectrum) > kInaudible * loudest_) entry->second = make_(tables);
  }
  return entry->second.get();
}

void DopplerSynthesis::add_nodes(const PingTask& task, DopplerScratch& scratch,
                                 const Workers& workers) const {
  scratch.sum.assign(cells(), 0);
  scratch.mean.assign(task.wants_clean ? cells() : 0, 0);
  scratch.channels.assign(task.wants_channels ? channel_cells() : 0, 0);
  std::set<int> needed = {0};  // node 0 also has noise and volumes
  for (const Scatterer& s : task.scatterers->items) {
    if (s.doppler == 0) continue;
    const DopplerWeights weights = weights_at(nodes_, static_cast<double>(s.doppler));
    for (int q = 0; q <= nodes_.degree; ++q) {
      if (weights.value[q] != 0) needed.insert(weights.first_node + weights.step * q);
    }
  }
  for (const int node : needed) add_node(task, node, scratch, workers);
}

void DopplerSynthesis::add_node(const PingTask& task, int node, DopplerScratch& scratch,
                                const Workers& workers) const {
  const PingSynthesis* synthesis = at_node(node);
  if (synthesis == nullptr) return;
  const auto weigh = [&](Scatterer& s) {
    const DopplerWeights weights = weights_at(nodes_, static_cast<double>(s.doppler));
    const int q = weights.step * (node - weights.first_node);
    if (q < 0 || q > nodes_.degree || weights.value[q] == 0) return false;
    s.gain = static_cast<float>(s.gain * weights.value[q]);
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

DopplerNodes choose_doppler_nodes(const DopplerPulse& pulse, double tolerance) {
  Judge judge(pulse, tolerance);
  const double bin = pulse.sonar.bandwidth_hz / (pulse.sonar.frequency_hz * pulse.transform);
  DopplerNodes best;
  double least = kMostCost, width = 0;
  for (const int degree : {2, 3, 4, 6, 8, 11, 16, DopplerNodes::kMostDegree}) {
    // A higher degree holds for all widths for which a lower degree does.
    double low = std::max(width, bin * degree / kMostNodesPerBin), high = kWidest;
    if (low * kStep >= high || !judge.holds({degree, low})) continue;
    while (high > kStep * low) {
      const double middle = std::sqrt(low * high);
      (judge.holds({degree, middle}) ? low : high) = middle;
    }
    width = low;
    // The expected number of nodes, because the span may begin anywhere within a band.
    const double cost = degree * (kNominalSpan / width + 1) + 1;
    if (cost > 1.5 * least) break;
    if (cost >= least) continue;
    least = cost;
    best = {degree, width};
  }
  return best;
}

double node_doppler(const DopplerNodes& nodes, int node) {
  const int n = std::abs(node);
  const double doppler =
      (n / nodes.degree + place_in_band(n % nodes.degree, nodes.degree)) * nodes.width;
  return node < 0 ? -doppler : doppler;
}

DopplerWeights weights_at(const DopplerNodes& nodes, double doppler) {
  DopplerWeights weights;
  weights.step = doppler < 0 ? -1 : 1;
  const double at = std::abs(doppler) / nodes.width;
  const int band = static_cast<int>(at);
  const double u = at - band;
  weights.first_node = weights.step * band * nodes.degree;
  // Barycentric interpolation (Berrut and Trefethen, SIAM Review 46, 2004).
  double sum = 0;
  for (int q = 0; q <= nodes.degree; ++q) {
    const double distance = u - place_in_band(q, nodes.degree);
    if (distance == 0) {
      weights.value = {};
      weights.value[q] = 1;
      return weights;
    }
    const double end = q == 0 || q == nodes.degree ? 0.5 : 1.0;
    weights.value[q] = (q % 2 == 0 ? end : -end) / distance;
    sum += weights.value[q];
  }
  for (int q = 0; q <= nodes.degree; ++q) weights.value[q] /= sum;
  return weights;
}

double largest_magnitude(const std::vector<std::complex<double>>& spectrum) {
  double most = 0;
  for (const Complex& s : spectrum) most = std::max(most, std::abs(s));
  return most;
}

std::unique_ptr<PingSynthesis> make_doppler_synthesis(const SynthesisTables& tables,
                                                      MakeSynthesis make) {
  SynthesisTables finer = tables;
  finer.setup.tolerance = std::min(tables.setup.tolerance, kMeanTolerance);
  DopplerPulse pulse = make_doppler_pulse(tables.setup.sonar, tables.setup.record.transform);
  const DopplerNodes nodes = choose_doppler_nodes(pulse, finer.setup.tolerance);
  if (nodes.degree == 0) return nullptr;
  return std::make_unique<DopplerSynthesis>(std::move(finer), std::move(make), std::move(pulse),
                                            nodes);
}

}  // namespace ensonify
