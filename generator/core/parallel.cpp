#include "core/parallel.h"

#include <algorithm>
#include <thread>

#if defined(ENSONIFY_HAVE_TBB)
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#else
#include <atomic>
#include <exception>
#include <mutex>
#include <vector>
#endif

namespace ensonify {
namespace {

int thread_count(int asked) {
  if (asked > 0) return asked;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace

#if defined(ENSONIFY_HAVE_TBB)

int most_threads() { return std::max(256, 4 * thread_count(0)); }

struct Workers::Impl {
  explicit Impl(int n)
      : threads(n),
        // By default TBB uses no more threads than the machine has cores, and the smallest of all
        // live limits applies to all.
        limit(tbb::global_control::max_allowed_parallelism, most_threads()),
        arena(n) {}
  int threads;
  tbb::global_control limit;
  tbb::task_arena arena;
};

void Workers::for_each(std::size_t count, const std::function<void(std::size_t)>& body) const {
  impl_->arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, body); });
}

bool workers_are_tbb() { return true; }

#else

bool workers_are_tbb() { return false; }

struct Workers::Impl {
  explicit Impl(int n) : threads(n) {}
  int threads;
};

void Workers::for_each(std::size_t count, const std::function<void(std::size_t)>& body) const {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    for (std::size_t i; (i = next.fetch_add(1)) < count;) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard lock(failure_mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  const auto helpers = std::min<std::size_t>(impl_->threads, count);
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 1; i < helpers; ++i) threads.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

#endif

Workers::Workers(int threads, StageTimes* stage_times)
    : impl_(std::make_unique<Impl>(thread_count(threads))), stage_times_(stage_times) {}
Workers::~Workers() = default;
int Workers::threads() const { return impl_->threads; }

}  // namespace ensonify
