// Parts of a plan for processes that do not communicate.
//
//   Shard  parse_shard      "2/5"
//   slurm_shard             of a task in a Slurm array
//   runs_of_shard           the runs of a plan that belong to a shard
//   range_of_shard          the part of a number of equal pieces of work
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "sweep/folder.h"

namespace ensonify {

struct Shard {
  std::size_t number = 0;  // 0 ... count - 1
  std::size_t count = 1;

  friend bool operator==(const Shard&, const Shard&) = default;
};

// K/N with 0 <= K < N. Errors (usage).
Result<Shard> parse_shard(std::string_view text);

// (SLURM_ARRAY_TASK_ID - _MIN) / _STEP of _COUNT; `variable` returns the value of each variable,
// null if it is not set. Empty outside an array. Errors (usage): variables that do not give a
// shard, as in every task of an array with gaps (--array=1,3,7), which _MAX reveals.
Result<std::optional<Shard>> slurm_shard(const std::function<const char*(const char*)>& variable);

// Increasing indexes into the plan. Each run is in exactly one shard, which depends only on the
// plan: the longest run first, each to the shard with the least work so far.
std::vector<std::size_t> runs_of_shard(const Plan& plan, const Shard& shard);

// [first, last) of `count`: the ranges of the shards follow each other, differ in size by at most
// one, and are empty if there are fewer pieces than shards.
std::pair<std::uint32_t, std::uint32_t> range_of_shard(std::uint32_t count, const Shard& shard);

}  // namespace ensonify
