#include "run/world_census.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "compare/jackknife.h"
#include "core/counted.h"
#include "run/terminal.h"

namespace ensonify {
namespace {

struct Look {
  std::optional<Placement> placement;
  std::optional<Error> error;
};

// "3 (1.5 %, at most 3.8 % with 95 % confidence)"; without the bound if all sequences were built.
std::string share_text(std::uint64_t hits, const WorldCensus& census) {
  const double share =
      100 * static_cast<double>(hits) / std::max(1.0, static_cast<double>(census.looked_at));
  if (census.looked_at == census.sequences) return fmt::format("{} ({:.2g} %)", hits, share);
  return fmt::format("{} ({:.2g} %, at most {:.2g} % with 95 % confidence)", hits, share,
                     100 * rate_bound(hits, census.looked_at));
}

}  // namespace

Result<WorldCensus> take_census(const SequenceWorlds& worlds, std::uint32_t most,
                                const Workers& workers) {
  WorldCensus census;
  census.sequences = worlds.first().scenario.sequences;
  if (!worlds.vary()) return census;
  const std::uint64_t all = census.sequences;
  census.looked_at = static_cast<std::uint32_t>(std::min<std::uint64_t>(all, most));
  std::vector<Look> looks(census.looked_at);
  const auto sequence_of = [&](std::size_t i) {
    return static_cast<std::uint32_t>(i * all / census.looked_at);
  };
  {
    // A log does not need progress that takes only seconds.
    const bool is_long = census.looked_at > kWorldsLookedAt;
    const bool is_shown = is_long || progress_style(false) == ProgressStyle::bar;
    Progress progress(progress_style(!is_shown), census.looked_at, 0, "world");
    workers.for_each(looks.size(), [&](std::size_t i) {
      const Result<Session> session = worlds.session(sequence_of(i), ErrorPlaces::shown);
      if (session) {
        looks[i].placement = session->placement;
      } else {
        looks[i].error = session.error();
      }
      progress.one_done();
    });
  }
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (looks[i].placement) add(*looks[i].placement, census.placement);
    if (!looks[i].error) continue;
    if (looks[i].error->kind != ErrorKind::usage) {
      return of_sequence(sequence_of(i), *looks[i].error);
    }
    census.failed.push_back({sequence_of(i), looks[i].error->message});
  }
  return census;
}

std::vector<std::string> census_lines(const WorldCensus& census) {
  if (census.looked_at == 0) return {};
  std::vector<std::string> lines;
  lines.reserve(3);
  lines.push_back(fmt::format("worlds built: {} of {}; impossible: {}", census.looked_at,
                              census.sequences, share_text(census.failed.size(), census)));
  const PlacementTotals& placed = census.placement;
  if (placed.sequences == 0) return lines;
  lines.push_back(fmt::format("worlds sampled again for lack of room: {}, {} in total",
                              share_text(placed.redrawn, census),
                              counted(placed.redraws, "redraw")));
  if (placed.redrawn == 0 && placed.left_out == 0) return lines;
  const auto mean = [&](std::uint64_t sum) {
    return static_cast<double>(sum) / static_cast<double>(placed.sequences);
  };
  std::string text;
  for (const PlacedClass& of : placed.classes) {
    text += fmt::format("{} {} {:.2f} of {:.2f}", text.empty() ? "" : ",", of.class_name,
                        mean(of.kept), mean(of.first));
  }
  lines.push_back(fmt::format("objects per sequence, kept of first sampled:{}", text));
  return lines;
}

}  // namespace ensonify
