#include "sweep/expand.h"

#include <map>
#include <mutex>
#include <unordered_map>
#include <unordered_set>

#include <fmt/format.h>

#include "formats/files.h"
#include "formats/sha256.h"
#include "scenario/distribution.h"
#include "scenario/draw.h"
#include "scenario/scenario.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// Each input file is read once, however many runs name it.
class FileHashes {
 public:
  Result<std::string> of(const fs::path& file) {
    const std::lock_guard lock(mutex_);
    const auto [known, fresh] = hashes_.try_emplace(file.string(), std::string());
    if (fresh) known->second = sha256_of_file(file);
    return known->second;
  }

 private:
  std::mutex mutex_;
  std::unordered_map<std::string, Result<std::string>> hashes_;
};

Faults faults_of(const SweepFile& file) {
  Faults faults;
  for (const std::string& label : file.sources) add_source(faults, label);
  return faults;
}

Node tree_of(const SweepFile& file, const Point& point, Faults& faults) {
  Node tree = *file.tree;
  for (const Setting& setting : settings_of(file, point)) apply_setting(tree, setting, faults);
  return tree;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

// `key.path: trouble` with the place of that key, which is in the sweep file if a value there is
// wrong.
std::string placed(const SweepFile& file, const Node& tree, const std::string& line) {
  const auto place = place_in(tree, std::string_view(line).substr(0, line.find(": ")));
  const auto label = [&](int source) { return file.sources[static_cast<std::size_t>(source)]; };
  if (place && place->line > 0) {
    return fmt::format("{}:{}:{}: {}", label(place->source), place->line, place->column, line);
  }
  // --set has a source of its own, without lines, after those of the sweep and the base.
  return fmt::format("{}: {}", label(place && place->source > 1 ? place->source : 1), line);
}

Error all_placed(const Error& error, const SweepFile& file, const Node& tree) {
  std::vector<std::string> lines = lines_of(error.message);
  for (std::string& line : lines) line = placed(file, tree, line);
  return {error.kind, fmt::format("{}", fmt::join(lines, "\n"))};
}

Result<std::string> id_of(const Scenario& scenario, FileHashes& hashes) {
  std::map<fs::path, std::string> names;
  for (const fs::path& path : input_files(scenario)) {
    const Result<std::string> hash = hashes.of(path);
    if (!hash) return hash.error();
    names[path] = "assets/" + *hash + path.extension().string();
  }
  const std::string text = to_yaml(scenario, [&](const fs::path& path) {
    const auto found = names.find(path);
    return found == names.end() ? path.string() : found->second;
  });
  return sha256_hex(text).substr(0, kRunIdDigits);
}

struct Resolved {
  SweepRun run;
  std::optional<Error> error;
};

Resolved resolve(const SweepFile& file, Point point, const CostOf& cost_of, FileHashes& hashes) {
  Resolved made;
  made.run.name = name_of(file, point);
  Faults faults = faults_of(file);
  const Node tree = tree_of(file, point, faults);
  made.run.point = std::move(point);
  const bool sampled = holds_distribution(tree);
  const Result<Scenario> scenario = first_readable(
      sampled, [&](std::uint32_t sequence) { return scenario_of(file, made.run.point, sequence); });
  if (scenario) check_draws(tree, file.sources[1], file.base.parent_path(), faults);
  if (!scenario || !faults.empty()) {
    made.error = scenario ? to_error(faults) : scenario.error();
    return made;
  }
  made.run.seed = scenario->seed;
  const Result<std::string> id = id_of(*scenario, hashes);
  if (!id) {
    made.error = id.error();
    return made;
  }
  made.run.id = *id;
  const Result<Cost> cost = first_readable(sampled, [&](std::uint32_t sequence) -> Result<Cost> {
    if (sequence == 0) return cost_of(*scenario);
    Result<Scenario> other = scenario_of(file, made.run.point, sequence);
    return other ? cost_of(std::move(*other)) : Result<Cost>(other.error());
  });
  if (cost) {
    made.run.cost = *cost;
    return made;
  }
  made.error = all_placed(cost.error(), file, tree);
  return made;
}

// Each line once, with the runs that have it.
Error all_errors(const std::vector<Resolved>& all) {
  struct Told {
    std::string line;
    std::size_t first_run, runs;
  };
  std::vector<Told> told;
  std::unordered_map<std::string, std::size_t> index;
  ErrorKind kind = ErrorKind::usage;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i].error) continue;
    if (all[i].error->kind != ErrorKind::usage) kind = all[i].error->kind;
    for (std::string& line : lines_of(all[i].error->message)) {
      const auto [known, fresh] = index.try_emplace(line, told.size());
      if (fresh) told.push_back({std::move(line), i, 0});
      ++told[known->second].runs;
    }
  }
  std::vector<std::string> lines;
  for (const auto& [line, first_run, runs] : told) {
    if (lines.size() == kMaxFaults) {
      lines.push_back(fmt::format("and {} more", told.size() - lines.size()));
      break;
    }
    const std::string more = runs > 1 ? fmt::format(" and {} more", runs - 1) : "";
    const bool every = runs > 1 && runs == all.size();
    lines.push_back(
        every ? line + " (every run)"
              : fmt::format("{} (run {}{})", line, one_line(all[first_run].run.name), more));
  }
  return {kind, fmt::format("{}", fmt::join(lines, "\n"))};
}

}  // namespace

Result<Sweep> expand_sweep(SweepFile file, const CostOf& cost_of, const Workers& workers) {
  Result<std::vector<Point>> points = points_of(file);
  if (!points) return points.error();
  FileHashes hashes;
  std::vector<Resolved> all(points->size());
  workers.for_each(all.size(), [&](std::size_t i) {
    all[i] = resolve(file, std::move((*points)[i]), cost_of, hashes);
  });
  for (const Resolved& one : all) {
    if (one.error) return all_errors(all);
  }
  Sweep sweep;
  sweep.left_out = file.product - all.size();
  sweep.file = std::move(file);
  std::unordered_set<std::string> ids;
  for (Resolved& one : all) {
    if (ids.insert(one.run.id).second) sweep.runs.push_back(std::move(one.run));
  }
  sweep.repeated = all.size() - sweep.runs.size();
  return sweep;
}

Plan plan_of(const Sweep& sweep) {
  Plan plan;
  for (const SweepRun& run : sweep.runs) {
    PlannedRun planned{run.id, run.name, {}, run.seed, run.cost.pings, run.cost.core_s, {}};
    for (const auto& [axis, value] : values_of(sweep.file, run.point)) {
      planned.values.emplace_back(axis.name, value.json);
      for (const Setting& setting : value.settings) {
        planned.settings.emplace_back(setting.path, json_of_node(setting.value));
      }
    }
    plan.push_back(std::move(planned));
  }
  return plan;
}

Result<Scenario> scenario_of(const SweepFile& file, const Point& point, SequenceDraw draw,
                             ErrorPlaces places) {
  Faults faults = faults_of(file);
  auto scenario = parse_scenario_tree(tree_of(file, point, faults), file.sources[1],
                                      file.base.parent_path(), faults, draw);
  if (!scenario) return to_error(faults, places);
  return std::move(*scenario);
}

Result<Scenario> first_scenario_of(const SweepFile& file, const Point& point) {
  return first_readable(true,
                        [&](std::uint32_t sequence) { return scenario_of(file, point, sequence); });
}

Error with_place(const Error& error, const SweepFile& file, const Point& point) {
  Faults faults = faults_of(file);
  return all_placed(error, file, tree_of(file, point, faults));
}

}  // namespace ensonify
