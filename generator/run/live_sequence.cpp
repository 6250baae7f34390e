#include "run/live_sequence.h"

#include <type_traits>
#include <utility>
#include <vector>

#include "core/image_planes.h"
#include "formats/bytes.h"
#include "ping/sequence_info.h"
#include "run/display_limits.h"
#include "run/memory_room.h"

namespace ensonify {
namespace {

// The limits are computed once, because they hold for the whole data set.
Result<std::array<double, 2>> limits_of(StreamSource& source, const Workers& workers) {
  const std::lock_guard lock(source.mutex);
  if (source.limits_db) return *source.limits_db;
  auto limits_db =
      display_limits_db(source.worlds.first().scenario.output, worlds_from_first(source.worlds),
                        source.numerics, workers, source.worlds.vary() ? nullptr : &source.shared);
  if (limits_db) source.limits_db = *limits_db;
  return limits_db;
}

SequenceInfo info_of(const Session& session, std::uint32_t sequence, PingRange pings,
                     const OutputSelection& output) {
  SequenceInfo info = sequence_info(session, sequence, pings.first, pings.second);
  info.output = output;
  if (!output.cartesian) info.cartesian.reset();
  return info;
}

// Files store all float planes as half floats except those of groups.
void round_planes(LabelledImage& image) {
  for (const ImagePlane& plane : kImagePlanes) {
    if (has_own_file(plane)) continue;
    with_plane(image, plane, [&](auto& values) {
      if constexpr (std::is_same_v<std::decay_t<decltype(values)>, std::vector<float>>) {
        round_to_halves(values);
      }
    });
  }
}

}  // namespace

Result<std::shared_ptr<StreamSource>> open_source(const ScenarioOptions& input,
                                                  BackendChoice backend) {
  Result<SequenceWorlds> worlds = SequenceWorlds::open(input, true);
  if (!worlds) return worlds.error();
  if (Status can = need_sonar(worlds->first().scenario); !can) return can.error();
  Result<Numerics> numerics = settle_backend(backend, best_simd_level());
  if (!numerics) return numerics.error();
  numerics->tables = std::make_shared<TableCache>();
  std::vector<std::string> warnings;
  if (!numerics->no_device.empty()) warnings.push_back("no device: " + numerics->no_device);
  numerics = numerics_that_fit(worlds->first(), worlds->first_tracer(), *numerics,
                               [&](std::string_view text) { warnings.emplace_back(text); });
  if (!numerics) return worlds->placed(numerics.error());
  return std::shared_ptr<StreamSource>(
      new StreamSource{std::move(*worlds), std::move(*numerics), {}, {}, {}, std::move(warnings)});
}

Result<std::shared_ptr<const LiveSequence>> open_sequence(StreamSource& source,
                                                          std::uint32_t sequence,
                                                          const OutputSelection& output,
                                                          const Workers& workers) {
  Result<ReadyWorld> world = source.worlds.world(sequence);
  if (!world) return world.error();
  const Session& session = *world->session;
  const PingRange pings{0, static_cast<std::uint32_t>(session.ping_times_s.size())};
  SequenceInfo info = info_of(session, sequence, pings, output);
  if (output.png) {
    const auto limits_db = limits_of(source, workers);
    if (!limits_db) return limits_db.error();
    info.png.limits_db = *limits_db;
  }
  SharedParts shared;
  if (!source.worlds.vary()) {
    const std::lock_guard lock(source.mutex);
    shared = source.shared;
  }
  Result<ReadyPipeline> ready =
      make_pipeline(session, *world->tracer, std::move(info), source.numerics, workers, shared);
  if (!ready) return ready.error();
  auto info_made = std::make_shared<const SequenceInfo>(ready->pipeline.info());
  auto tables = shared.tables;
  if (!source.worlds.vary()) {
    // The echoes of one scene lack what other selections of output need.
    shared.scene.reset();
    const std::lock_guard lock(source.mutex);
    source.shared = std::move(shared);
  }
  return std::shared_ptr<const LiveSequence>(
      new LiveSequence{std::move(*world), pings, std::move(ready->pipeline), std::move(info_made),
                       std::move(tables)});
}

PingResult live_ping(const LiveSequence& sequence, std::uint32_t ping, const Workers& workers) {
  PingResult result = sequence.pipeline.run(ping, workers);
  result.scatterers = {};
  if (result.polar) round_planes(*result.polar);
  if (result.cartesian) round_planes(*result.cartesian);
  return result;
}

}  // namespace ensonify
