// Elastic bodies: their echoes for one sonar.
//
//   RingingLibrary  ring_bodies
#pragma once

#include <mutex>
#include <vector>

#include "core/sonar.h"
#include "scenario/scenario.h"
#include "world/world.h"

namespace ensonify {

// The responses of elastic bodies, each computed once for all worlds. May be used from several
// threads at once.
class RingingLibrary {
 public:
  Ringing response(const ElasticBody& body, bool is_cylinder, const Sonar& sonar,
                   const Water& water);

 private:
  struct Known {
    ElasticBody body;
    bool is_cylinder = false;
    double frequency_hz = 0, bandwidth_hz = 0, sound_speed_m_s = 0, density_kg_m3 = 0;
    Ringing ringing = {};
  };
  std::mutex mutex_;
  std::vector<Known> known_;
};

// Gives the objects and point targets of the world that are elastic in the scenario, which has them
// in the same order, their taps over the sonar's band and their instances the body; targets also
// get the target strength at the carrier. `library` is shared by worlds, and may be null.
void ring_bodies(const Scenario& scenario, const Sonar& sonar, const Water& water,
                 RingingLibrary* library, World& world);

}  // namespace ensonify
