#include "sweep/shards.h"

#include <algorithm>
#include <charconv>
#include <numeric>
#include <queue>
#include <tuple>

#include <fmt/format.h>

#include "core/error.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr std::size_t kMaxShards = 1'000'000;

std::optional<std::size_t> whole(std::string_view text) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// The work of a bin. A run counts at least a little, so that runs without cost are spread as well.
double weight_of(const PlannedRun& run) { return std::max(run.cost, 1e-9); }

}  // namespace

Result<Shard> parse_shard(std::string_view text) {
  const std::size_t slash = text.find('/');
  if (slash != std::string_view::npos) {
    const auto number = whole(text.substr(0, slash));
    const auto count = whole(text.substr(slash + 1));
    if (number && count && *number < *count && *count <= kMaxShards) return Shard{*number, *count};
  }
  return Error{
      ErrorKind::usage,
      fmt::format("--shard {}: not a shard; expected K/N, from 0/N to (N-1)/N, with N up to {}",
                  shown(text), kMaxShards)};
}

Result<std::optional<Shard>> slurm_shard(const std::function<const char*(const char*)>& variable) {
  const char* id_text = variable("SLURM_ARRAY_TASK_ID");
  if (id_text == nullptr) return std::optional<Shard>();
  const auto number_of = [&](const char* name, std::optional<std::size_t> otherwise) {
    const char* text = variable(name);
    return text == nullptr ? otherwise : whole(text);
  };
  const auto id = whole(id_text);
  const auto first = number_of("SLURM_ARRAY_TASK_MIN", std::nullopt);
  const auto count = number_of("SLURM_ARRAY_TASK_COUNT", std::nullopt);
  const auto step = number_of("SLURM_ARRAY_TASK_STEP", 1);
  const auto last = number_of("SLURM_ARRAY_TASK_MAX", id);
  if (id && first && last && count && step && *id >= *first && *last >= *id && *step > 0 &&
      (*id - *first) % *step == 0 && (*id - *first) / *step < *count && *count <= kMaxShards) {
    // Each task detects gaps if the last task of the array is known.
    const bool whole =
        variable("SLURM_ARRAY_TASK_MAX") == nullptr || (*last - *first) / *step + 1 == *count;
    if (whole) return std::optional(Shard{(*id - *first) / *step, *count});
  }
  const auto said = [&](const char* name) {
    const char* text = variable(name);
    return fmt::format("{}={}", name, text == nullptr ? "(not set)" : one_line(text));
  };
  return Error{ErrorKind::usage,
               fmt::format("{}, {}, {}, {} do not give a shard; expected an array without gaps "
                           "such as --array=0-9, or --shard K/N",
                           said("SLURM_ARRAY_TASK_ID"), said("SLURM_ARRAY_TASK_MIN"),
                           said("SLURM_ARRAY_TASK_MAX"), said("SLURM_ARRAY_TASK_COUNT"))};
}

std::vector<std::size_t> runs_of_shard(const Plan& plan, const Shard& shard) {
  std::vector<std::size_t> order(plan.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return weight_of(plan[a]) > weight_of(plan[b]);
  });
  using Bin = std::tuple<double, std::size_t>;  // load, number of the shard
  std::priority_queue<Bin, std::vector<Bin>, std::greater<>> bins;
  for (std::size_t i = 0; i < shard.count; ++i) bins.emplace(0.0, i);
  std::vector<std::size_t> taken;
  for (const std::size_t run : order) {
    const auto [load, number] = bins.top();
    bins.pop();
    if (number == shard.number) taken.push_back(run);
    bins.emplace(load + weight_of(plan[run]), number);
  }
  std::sort(taken.begin(), taken.end());
  return taken;
}

std::pair<std::uint32_t, std::uint32_t> range_of_shard(std::uint32_t count, const Shard& shard) {
  ENSONIFY_ASSERT(shard.number < shard.count);
  // The first shards take the remainder; no product overflows.
  const std::size_t each = count / shard.count, left = count % shard.count;
  const auto first = [&](std::size_t number) {
    return static_cast<std::uint32_t>(number * each + std::min(number, left));
  };
  return {first(shard.number), first(shard.number + 1)};
}

}  // namespace ensonify
