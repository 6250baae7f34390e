// Parts of a plan for processes that know nothing of each other.
//
//   Shard  parse_shard      "2/5"
//   slurm_shard             of a task of a SLURM array
//   runs_of_shard           which runs of a plan
//   range_of_shard          which of so many equal pieces of work
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

// (SLURM_ARRAY_TASK_ID - _MIN) / _STEP of _COUNT; `variable` is asked for each and gives null where
// it is not set. Nothing outside an array. Errors (usage): variables that make no shard, as in
// every task of an array with holes (--array=1,3,7), which _MAX tells.
Result<std::optional<Shard>> slurm_shard(const std::function<const char*(const char*)>& variable);

// Indexes into the plan, rising. Each run is in one shard; taken from the plan alone: the longest
// first, each to the shard that has least to do so far.
std::vector<std::size_t> runs_of_shard(const Plan& plan, const Shard& shard);

// [first, last) of `count`: the shards' ranges follow each other, are at most one apart in size,
// and are empty where there are fewer pieces than shards.
std::pair<std::uint32_t, std::uint32_t> range_of_shard(std::uint32_t count, const Shard& shard);

}  // namespace ensonify
