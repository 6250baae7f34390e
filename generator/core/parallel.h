// The only source of threads: TBB if available, std::jthread otherwise (a machine without TBB, or
// the thread sanitizer, which reports false races inside TBB).
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace ensonify {

struct StageTimes;

class Workers {
 public:
  // With threads = 0, uses as many threads as the machine has. `stage_times` receives the processor
  // time of the stages that these workers run (stage_times.h).
  explicit Workers(int threads = 0, StageTimes* stage_times = nullptr);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int threads() const;
  StageTimes* stage_times() const { return stage_times_; }

  // Calls body(i) once for every i in [0, count), in any order, and returns when all are done. Each
  // i must write only what it owns, so that results do not depend on the number of threads.
  // Rethrows an exception of a body.
  void for_each(std::size_t count, const std::function<void(std::size_t)>& body) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  StageTimes* stage_times_;
};

// Whether Workers use TBB. If not, no library may start TBB's threads either.
bool workers_are_tbb();

}  // namespace ensonify
