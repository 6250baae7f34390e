#include "synthesis/cpu/array_power.h"

#include <algorithm>

namespace ensonify {
namespace {
class NoPower final : public ArrayPower {
 public:
  explicit NoPower(std::size_t n) : n_(n) {}
  SynthesisMemory memory() const override { return {}; }
  void diffuse(const PingTask&, std::vector<float>& power, const Workers&) const override {
    power.assign(n_, 0.0f);
  }
  std::size_t n_;
};
}  // namespace

std::unique_ptr<const ArrayPower> make_array_power(const SynthesisTables& t) {
  return std::make_unique<NoPower>(std::size_t(t.setup.sonar.beam_count) * t.setup.record.samples);
}

bool has_means(const PingTask& task) {
  const auto& items = task.scatterers->items;
  return std::any_of(items.begin(), items.end(),
                     [](const Scatterer& s) { return s.mean != 0.0f; });
}

}  // namespace ensonify
