// Where the time of a ping goes: processor time by stage, for benchmarks.
//
//   Stage  stage_name  is_physics
//   StageTimes    sums over pings and threads
//   StageTimer    adds the time of its scope
//   timed         ... of a call
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "core/parallel.h"

namespace ensonify {

enum class Stage {
  world,        // shapes, meshes and terrain, with the tracer's hierarchies
  tables,       // what follows from sonar, water and record
  trace,        // rays to hits
  scatterers,   // hits to scatterers and volume echoes, sorted
  hidden,       // what lies behind the first hits
  synthesis,    // scatterers to series and expected power
  labels,       // polar image
  shadow,       // shadows and amodal sets
  annotations,  // boxes and run lengths, both views
  cartesian,    // all planes resampled
  grey,
  encode_npy,
  encode_exr,
  encode_png,  // images and masks
  encode_other,
  hash,     // SHA-256 of every file
  record,   // the ping's entry for the tables
  store,    // written and renamed
  moments,  // of realizations of one scene
};
inline constexpr int kStageCount = 19;

const char* stage_name(Stage stage);

// Whether the stage computes the paper's model.
bool is_physics(Stage stage);

struct StageTimes {
  std::array<std::atomic<std::int64_t>, kStageCount> ns{};
};

// Counts the processor time of this thread in its scope; nothing if the workers do not count. Other
// threads that help with the stage are not counted: give each ping one thread.
class StageTimer {
 public:
  StageTimer(const Workers& workers, Stage stage);
  ~StageTimer();
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  std::atomic<std::int64_t>* sum_ = nullptr;
  std::int64_t start_ns_ = 0;
};

// Returns what `work` returns.
template <class Work>
decltype(auto) timed(const Workers& workers, Stage stage, Work&& work) {
  const StageTimer timer(workers, stage);
  return work();
}

}  // namespace ensonify
