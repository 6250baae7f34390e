// Pings of a scene without files.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ping/pipeline.h"
#include "ping/prepare_session.h"
#include "ping/sequence_info.h"
#include "ping/session.h"
#include "results.h"
#include "temporary_folder.h"

namespace ensonify::test {

inline Pipeline pipeline_of(const Session& session, const Tracer& tracer, const SequenceInfo& info,
                            const Numerics& numerics = {}) {
  SharedParts shared;
  auto ready = make_pipeline(session, tracer, info, numerics, Workers(2), shared);
  if (!ready) throw std::runtime_error(ready.error().message);
  return std::move(ready->pipeline);
}

inline Session prepared(Result<Scenario> scenario, std::uint32_t sequence = 0) {
  return value_of(prepare_session(value_of(std::move(scenario)), sequence));
}
// Of a scenario's text; `folder` holds the files that it names.
inline Session prepared(const std::string& text, const std::vector<Override>& overrides = {},
                        const std::filesystem::path& folder = ".") {
  return prepared(parse_scenario(text, "scene.yaml", folder, overrides));
}

class SceneRun {
 public:
  explicit SceneRun(const std::string& name, const std::vector<Override>& overrides = {})
      : SceneRun(prepared(load_scenario(std::filesystem::path(ENSONIFY_SCENES) / (name + ".yaml"),
                                        overrides)),
                 {}) {}
  // Of a scenario's text.
  static SceneRun of_text(const std::string& text, const std::vector<Override>& overrides = {},
                          const Numerics& numerics = {}) {
    return SceneRun(prepared(text, overrides), numerics);
  }

  const Session& session() const { return session_; }
  const SequenceInfo& info() const { return pipeline_.info(); }
  std::vector<double> expected_pa2() const { return pipeline_.expected_pa2(); }
  PingResult ping(std::uint32_t number, int threads = 2) const {
    return pipeline_.run(number, Workers(threads));
  }

 private:
  SceneRun(Session session, const Numerics& numerics)
      : session_(std::move(session)),
        tracer_(session_.world),
        pipeline_(pipeline_of(session_, tracer_, sequence_info(session_, 0, 0, 1), numerics)) {}
  Session session_;
  Tracer tracer_;
  Pipeline pipeline_;
};

}  // namespace ensonify::test
