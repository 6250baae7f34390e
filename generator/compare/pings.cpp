#include "compare/pings.h"

#include <algorithm>

namespace ensonify {
namespace {

constexpr std::size_t kFewSequences = 10, kManyBlocks = 40;

using PingRange = std::pair<std::uint32_t, std::uint32_t>;

void add_runs(std::size_t sequence, const PingRange& pings, std::size_t runs, std::size_t length,
              std::vector<PingRun>& all) {
  std::uint32_t first = pings.first;
  for (const std::size_t part : block_sizes(pings.second - pings.first, runs)) {
    const std::size_t count = std::min(part, std::max<std::size_t>(1, length));
    all.push_back({sequence, first + static_cast<std::uint32_t>((part - count) / 2),
                   static_cast<std::uint32_t>(count)});
    first += static_cast<std::uint32_t>(part);
  }
}

}  // namespace

std::vector<std::size_t> block_sizes(std::size_t count, std::size_t blocks) {
  blocks = std::max<std::size_t>(1, std::min(blocks, count));
  std::vector<std::size_t> sizes;
  for (std::size_t b = 0; b < blocks; ++b) {
    sizes.push_back((b + 1) * count / blocks - b * count / blocks);
  }
  return sizes;
}

std::vector<PingRun> ping_runs(std::span<const PingRange> sequences, const Amount& amount) {
  auto blocks = static_cast<std::size_t>(amount.blocks);
  if (amount.blocks == 0) {
    blocks =
        sequences.size() < kFewSequences ? kFewSequences : std::min(sequences.size(), kManyBlocks);
  }
  blocks = std::min(blocks, static_cast<std::size_t>(amount.images));
  const std::size_t length = static_cast<std::size_t>(amount.images) / blocks;
  std::vector<PingRun> runs;
  if (sequences.size() >= blocks) {
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::size_t sequence = b * sequences.size() / blocks;
      add_runs(sequence, sequences[sequence], 1, length, runs);
    }
    return runs;
  }
  const auto shares = block_sizes(blocks, sequences.size());
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    add_runs(s, sequences[s], shares[s], length, runs);
  }
  return runs;
}

}  // namespace ensonify
