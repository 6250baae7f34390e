#include "core/stage_times.h"

#include <ctime>
#include <iterator>

namespace ensonify {
namespace {

constexpr const char* kStageNames[] = {"world",       "tables",     "trace",        "scatterers",
                                       "hidden",      "synthesis",  "labels",       "shadow",
                                       "annotations", "cartesian",  "grey",         "encode_npy",
                                       "encode_exr",  "encode_png", "encode_other", "hash",
                                       "record",      "store",      "moments"};
static_assert(std::size(kStageNames) == kStageCount);
static_assert(static_cast<int>(Stage::moments) == kStageCount - 1);

std::int64_t thread_ns() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::int64_t{1'000'000'000} * time.tv_sec + time.tv_nsec;
}

}  // namespace

const char* stage_name(Stage stage) { return kStageNames[static_cast<int>(stage)]; }

bool is_physics(Stage stage) {
  return stage == Stage::trace || stage == Stage::scatterers || stage == Stage::synthesis;
}

StageTimer::StageTimer(const Workers& workers, Stage stage) {
  if (workers.stage_times() == nullptr) return;
  sum_ = &workers.stage_times()->ns[static_cast<std::size_t>(stage)];
  start_ns_ = thread_ns();
}

StageTimer::~StageTimer() {
  if (sum_ != nullptr) *sum_ += thread_ns() - start_ns_;
}

}  // namespace ensonify
