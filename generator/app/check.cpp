
#include <cstdio>

#include "app/commands.h"
#include "app/cost.h"
#include "app/print.h"
#include "app/sequence_worlds.h"
#include "app/starved_cells.h"

namespace ensonify {
namespace {

// Every sequence of a scenario in which something is drawn, as far as that goes without its world.
Status check_sequences(const ScenarioOptions& options, const Workers& workers) {
  const Result<SequenceWorlds> worlds = SequenceWorlds::open(options);
  if (!worlds) return worlds.error();
  const Result<std::vector<SequenceInfo>> infos = worlds->all_infos({}, workers);
  return infos ? Status() : infos.error();
}

Result<Session> first_session(const ScenarioOptions& options) {
  const Result<std::string> text = read_scenario_text(options.scenario);
  if (!text) return text.error();
  const std::string label = options.scenario.string();
  Result<Scenario> scenario =
      parse_scenario(*text, label, options.scenario.parent_path(), options.overrides);
  if (!scenario) return scenario.error();
  Result<Session> session = prepare_session(std::move(*scenario), 0);
  if (!session) return with_place(session.error(), *text, label, options.overrides);
  return session;
}

}  // namespace

Status check(const ScenarioOptions& options) {
  const Result<Session> session = first_session(options);
  if (!session) return session.error();
  for (const std::string& warning : session->world.warnings) {
    tell("warning: {}\n", warning);
  }
  const int threads = Workers().threads();
  for (const auto& text : starved_warnings(*session, Tracer(session->world), Workers(threads))) {
    tell("warning: {}\n", text);
  }
  // Before anything else takes memory: it looks at what the process has.
  const Cost cost = estimate_cost(*session, threads);
  if (varies_by_sequence(session->scenario)) {
    Status valid = check_sequences(options, Workers(threads));
    if (!valid) return valid;
  }
  answer("{}", to_yaml(session->scenario,
                       [](const std::filesystem::path& file) { return file.string(); }));
  answer("# {} sequences x {} pings: {} beams x {} samples, {} rays a ping\n",
         session->scenario.sequences, session->ping_times_s.size(), session->sonar.beam_count,
         session->record.samples,
         std::uint64_t(session->sonar.beam_count) * session->sonar.rays_azimuth *
             session->sonar.rays_elevation);
  if (const auto& tiles = session->surface_tiles) {
    answer("# scatterers on surfaces: up to {} in the fan of a ping, in {} tiles\n",
           tiles->most_leaves, tiles->tiles.size());
  }
  answer("# files: {}\n# disk: about {}\n# peak memory: about {} with {} threads\n", cost.files,
         bytes_text(cost.disk_bytes), bytes_text(cost.peak_bytes), threads);
  return {};
}

}  // namespace ensonify
