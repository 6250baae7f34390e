#include <fmt/format.h>

#include <cstdio>

#include "app/commands.h"
#include "app/cost.h"
#include "app/sequence_worlds.h"
#include "app/starved_cells.h"

namespace ensonify {
namespace {

std::string bytes_text(std::uint64_t bytes) {
  const double b = static_cast<double>(bytes);
  if (b < 1e6) return fmt::format("{:.0f} kB", b / 1e3);
  if (b < 1e9) return fmt::format("{:.0f} MB", b / 1e6);
  return fmt::format("{:.1f} GB", b / 1e9);
}

}  // namespace

Status check(const ScenarioOptions& options) {
  const Result<SequenceWorlds> worlds = SequenceWorlds::open(options);
  if (!worlds) return worlds.error();
  const Session* session = &worlds->first();
  for (const std::string& warning : session->world.warnings) {
    fmt::print(stderr, "warning: {}\n", warning);
  }
  const int threads = Workers().threads();
  for (const auto& text : starved_warnings(*session, worlds->first_tracer(), Workers(threads))) {
    fmt::print(stderr, "warning: {}\n", text);
  }
  const Result<std::vector<SequenceInfo>> infos = worlds->all_infos({}, Workers(threads));
  if (!infos) return infos.error();
  const Cost cost = estimate_cost(*session, threads);
  fmt::print("{}", to_yaml(session->scenario,
                           [](const std::filesystem::path& file) { return file.string(); }));
  fmt::print("# {} sequences x {} pings: {} beams x {} samples, {} rays a ping\n",
             session->scenario.sequences, session->ping_times_s.size(), session->sonar.beam_count,
             session->record.samples,
             std::uint64_t(session->sonar.beam_count) * session->sonar.rays_azimuth *
                 session->sonar.rays_elevation);
  if (const auto& tiles = session->surface_tiles) {
    fmt::print("# scatterers on surfaces: up to {} in the fan of a ping, in {} tiles\n",
               tiles->most_leaves, tiles->tiles.size());
  }
  fmt::print("# files: {}\n# disk: about {}\n# peak memory: about {} with {} threads\n", cost.files,
             bytes_text(cost.disk_bytes), bytes_text(cost.peak_bytes), threads);
  return {};
}

}  // namespace ensonify
