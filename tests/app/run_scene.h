// Pings of a scene without files.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>

#include "ping/pipeline.h"
#include "ping/prepare_session.h"
#include "ping/sequence_info.h"
#include "ping/session.h"
#include "temporary_folder.h"

namespace ensonify::test {

inline Pipeline pipeline_of(const Session& session, const Tracer& tracer, const SequenceInfo& info,
                            const Numerics& numerics = {}) {
  SharedParts shared;
  auto ready = make_pipeline(session, tracer, info, numerics, Workers(2), shared);
  if (!ready) throw std::runtime_error(ready.error().message);
  return std::move(ready->pipeline);
}

class SceneRun {
 public:
  explicit SceneRun(const std::string& name, const std::vector<Override>& overrides = {})
      : SceneRun(load(std::filesystem::path(ENSONIFY_SCENES) / (name + ".yaml"), overrides)) {}
  // Of a scenario's text.
  static SceneRun of_text(const std::string& text) {
    const TemporaryFolder folder;
    return SceneRun(load(folder.write("scene.yaml", text), {}));
  }

  const Session& session() const { return session_; }
  const SequenceInfo& info() const { return pipeline_.info(); }
  PingResult ping(std::uint32_t number, int threads = 2) const {
    return pipeline_.run(number, Workers(threads));
  }

 private:
  explicit SceneRun(Session session)
      : session_(std::move(session)),
        tracer_(session_.world),
        pipeline_(pipeline_of(session_, tracer_, sequence_info(session_, 0, 0, 1))) {}
  static Session load(const std::filesystem::path& file, const std::vector<Override>& overrides) {
    auto scenario = load_scenario(file, overrides);
    if (!scenario) throw std::runtime_error(scenario.error().message);
    auto session = prepare_session(std::move(*scenario), 0);
    if (!session) throw std::runtime_error(session.error().message);
    return std::move(*session);
  }
  Session session_;
  Tracer tracer_;
  Pipeline pipeline_;
};

}  // namespace ensonify::test
