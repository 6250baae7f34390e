#include "run/sweep_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "run/cost.h"
#include "run/world_memory.h"
#include "scenario/rig.h"
#include "world/smooth_body.h"

namespace ensonify {

RunQueue::RunQueue(std::vector<std::uint64_t> items, int threads)
    : threads_(threads), left_(std::move(items)) {}

// Starting and ending a run take one thread; the others work on pings of another run meanwhile.
std::uint64_t RunQueue::wanted() const {
  return static_cast<std::uint64_t>(pings_under_way(threads_, UINT32_MAX)) + threads_;
}

int RunQueue::lanes() const {
  return static_cast<int>(std::min<std::uint64_t>(wanted(), left_.size()));
}

std::optional<RunQueue::Taken> RunQueue::take() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] {
    return stopped_ || next_ == left_.size() || under_way_ == 0 || items_under_way_ < wanted();
  });
  if (stopped_ || next_ == left_.size()) return std::nullopt;
  const std::size_t run = next_++;
  const std::uint64_t items = std::max<std::uint64_t>(left_[run], 1);
  ++under_way_;
  items_under_way_ += left_[run];
  const std::uint64_t by_items = (wanted() + items - 1) / items;
  const std::uint64_t to_come = under_way_ + left_.size() - next_;
  return Taken{run, static_cast<int>(std::min(by_items, to_come))};
}

void RunQueue::item_done(std::size_t run) {
  const std::lock_guard lock(mutex_);
  if (left_[run] == 0) return;
  --left_[run];
  --items_under_way_;
  changed_.notify_all();
}

void RunQueue::finish(std::size_t run) {
  const std::lock_guard lock(mutex_);
  items_under_way_ -= std::exchange(left_[run], 0);
  --under_way_;
  changed_.notify_all();
}

void RunQueue::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  changed_.notify_all();
}

MemoryGate::Hold& MemoryGate::Hold::operator=(Hold&& other) noexcept {
  if (this == &other) return *this;
  release();
  gate_ = std::exchange(other.gate_, nullptr);
  what_ = other.what_;
  bytes_ = other.bytes_;
  return *this;
}

void MemoryGate::Hold::release() {
  if (gate_ == nullptr) return;
  const std::lock_guard lock(gate_->mutex_);
  gate_->held_bytes_ -= bytes_;
  --gate_->held_;
  if (what_ == What::run) --gate_->runs_;
  gate_->changed_.notify_all();
  gate_ = nullptr;
}

MemoryGate::Hold MemoryGate::hold(What what, std::uint64_t bytes) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] {
    const bool fits = held_bytes_ <= budget_bytes_ && bytes <= budget_bytes_ - held_bytes_;
    return fits || (what == What::run ? runs_ : held_) == 0;
  });
  Hold hold;
  hold.gate_ = this;
  hold.what_ = what;
  hold.bytes_ = bytes;
  held_bytes_ += bytes;
  ++held_;
  if (what == What::run) ++runs_;
  return hold;
}

void MemoryGate::resize(Hold& hold, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  held_bytes_ += bytes - hold.bytes_;
  hold.bytes_ = bytes;
  changed_.notify_all();
}

bool MemoryGate::fits(std::uint64_t bytes, std::uint64_t runs) const {
  return bytes <= budget_bytes_ / runs;
}

std::string world_key(const Scenario& scenario) {
  Scenario part = scenario;
  part.drawn_sections.reset();  // as sampled for sequence 0, not as a distribution
  // Keys that build_world does not use.
  const Scenario none;
  part.name = none.name;
  part.speckle_seed = none.speckle_seed;
  part.sequences = none.sequences;
  part.sonar = none.sonar;
  part.rig = none.rig;
  part.instrument = none.instrument;
  part.water = none.water;
  part.scattering.speckle = none.scattering.speckle;
  part.multipath = none.multipath;
  part.bounces = none.bounces;
  const auto waits = [](const ObjectSpec& spec) {
    return spec.trajectory && spec.trajectory->from_first_ping;
  };
  if (std::ranges::none_of(part.objects, waits)) part.trajectory = none.trajectory;
  part.motion_within_ping = none.motion_within_ping;
  part.camera = none.camera;
  part.navigation = none.navigation;
  part.noise_spectrum_level_db = none.noise_spectrum_level_db;
  part.noise_snr_db = none.noise_snr_db;
  part.noise_correlated = none.noise_correlated;
  part.synthesis_tolerance = none.synthesis_tolerance;
  part.output = none.output;
  part.splits = none.splits;
  part.classes = none.classes;
  // The seed keys the random values of terrain, plumes, fish, places and wave motion.
  if (!varies_by_sequence(part)) part.seed = none.seed;
  std::string key = to_yaml(part, [](const std::filesystem::path& file) { return file.string(); });
  if (has_camera(scenario)) key += "with a camera\n";
  if (const auto hz = smoothness_hz(scenario)) key += fmt::format("smooth at {:a} Hz\n", *hz);
  // The text does not contain these: class numbers follow from everything that the scenario may
  // sample, and notices are printed with the warnings of the world.
  for (const std::string& name : scenario.class_names) key += name + "\n";
  for (const std::string& notice : scenario.notices) key += notice + "\n";
  return key;
}

Result<BuiltWorld> WorldCache::world(
    const std::string& key, const Scenario& scenario,
    const std::function<Result<BuiltWorld>(const Scenario&)>& build) {
  std::promise<Result<BuiltWorld>> promise;
  std::shared_future<Result<BuiltWorld>> world;
  std::uint64_t expected_bytes = 0;
  bool mine = false;
  {
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[key];
    mine = !entry.world.valid();
    if (mine) entry.world = promise.get_future().share();
    world = entry.world;
    expected_bytes = largest_bytes_;
  }
  if (!mine) return world.get();
  try {
    MemoryGate::Hold hold = gate_.hold(MemoryGate::What::world, expected_bytes);
    Result<BuiltWorld> built = build(scenario);
    const std::uint64_t bytes = built ? world_bytes(*built->world) : 0;
    gate_.resize(hold, bytes);
    {
      const std::lock_guard lock(mutex_);
      largest_bytes_ = std::max(largest_bytes_, bytes);
      const auto entry = entries_.find(key);
      if (entry != entries_.end()) entry->second.hold = std::move(hold);
    }
    promise.set_value(std::move(built));
  } catch (...) {
    promise.set_exception(std::current_exception());
  }
  return world.get();
}

void WorldCache::forget(const std::string& key) {
  Entry gone;
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) return;
  gone = std::move(entry->second);
  entries_.erase(entry);
}

}  // namespace ensonify
