// Pings of a scene without files.
#pragma once

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "app/pipeline.h"
#include "app/session.h"

namespace ensonify::test {

class SceneRun {
 public:
  explicit SceneRun(const std::string& name, const std::vector<Override>& overrides = {})
      : session_(load(name, overrides)), tracer_(session_.world) {
    pipeline_ =
        std::make_unique<Pipeline>(session_, tracer_, sequence_info(session_, 0, 0, 1), Numerics{});
    if (Status s = pipeline_->start_sequence(sequence_info(session_, 0, 0, 1), Workers(2)); !s) {
      throw std::runtime_error(s.error().message);
    }
  }
  const Session& session() const { return session_; }
  const SequenceInfo& info() const { return pipeline_->info(); }
  PingResult ping(std::uint32_t number, int threads = 2) const {
    return pipeline_->run(number, Workers(threads));
  }

 private:
  static Session load(const std::string& name, const std::vector<Override>& overrides) {
    auto scenario =
        load_scenario(std::filesystem::path(ENSONIFY_SCENES) / (name + ".yaml"), overrides);
    if (!scenario) throw std::runtime_error(scenario.error().message);
    auto session = prepare_session(std::move(*scenario), 0);
    if (!session) throw std::runtime_error(session.error().message);
    return std::move(*session);
  }
  Session session_;
  Tracer tracer_;
  std::unique_ptr<Pipeline> pipeline_;
};

}  // namespace ensonify::test
