#include "app/tables.h"

#include <fmt/format.h>

#include "app/motion.h"
#include "labels/cartesian.h"

namespace ensonify {
namespace {

std::shared_ptr<const PipelineTables> make_tables(const Session& session, const Numerics& numerics,
                                                  const DopplerRange& doppler) {
  auto tables = std::make_shared<PipelineTables>();
  tables->fan = make_fan(session.sonar);
  tables->backend = make_backend(
      numerics, {session.sonar, session.water, session.record, session.scenario.synthesis_tolerance,
                 numerics.simd, doppler.lowest, doppler.highest});
  if (session.scenario.output.selection.cartesian) {
    const CartesianGrid grid =
        cartesian_grid(session.sonar, session.scenario.output.cartesian_height_px);
    tables->cartesian_map = cartesian_map(grid, session.sonar, session.water, session.record);
  }
  tables->hidden_power = hidden_power(session.sonar, session.water, session.record);
  return tables;
}

}  // namespace

std::string table_key(const Scenario& scenario) {
  Scenario part;
  // As drawn, not as a distribution.
  part.sonar = scenario.sonar;
  part.water = scenario.water;
  part.scattering.normalization = scenario.scattering.normalization;
  part.synthesis_tolerance = scenario.synthesis_tolerance;
  part.output.selection.cartesian = scenario.output.selection.cartesian;
  part.output.cartesian_height_px = scenario.output.cartesian_height_px;
  // An array's errors are drawn from it.
  if (scenario.sonar.array) part.seed = scenario.seed;
  return to_yaml(part, [](const std::filesystem::path& file) { return file.string(); });
}

std::shared_ptr<const PipelineTables> pipeline_tables(const Session& session,
                                                      const Numerics& numerics) {
  const DopplerRange doppler = doppler_range(session);
  const auto make = [&] { return make_tables(session, numerics, doppler); };
  if (!numerics.tables) return make();
  const std::string key = fmt::format("{}doppler {} {}\n", table_key(session.scenario),
                                      doppler.lowest, doppler.highest);
  return numerics.tables->of(key, make);
}

std::shared_ptr<TableCache::Entry> TableCache::entry_of(const std::string& key) {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [](const auto& entry) { return entry.second.expired(); });
  std::shared_ptr<Entry> found = entries_[key].lock();
  if (!found) {
    found = std::make_shared<Entry>();
    entries_[key] = found;
  }
  std::erase(last_, found);
  last_.push_back(found);
  if (last_.size() > kKept) last_.pop_front();
  return found;
}

}  // namespace ensonify
