// Measures of an instance at a ping, the same for all images: how much of it is outside of the fan,
// and its contrast with the ground.
//
//   MeasuredInstances  measured_instances   values that depend on the world only
//   MeasuredPing  instance_measures          for one ping
#pragma once

#include <span>
#include <vector>

#include "core/ping.h"
#include "labels/annotations.h"
#include "ping/session.h"

namespace ensonify {

struct MeasuredInstances {
  std::vector<std::vector<Vec3>> surface_m;  // by World::objects: surface_samples
  // By instance id: the longest side of its bounding box, infinite for planes, terrain and
  // inward-facing shapes, which contain other objects; 0 without a box.
  std::vector<double> size_m;
};

MeasuredInstances measured_instances(const World& world);

struct MeasuredPing {
  const Session& session;
  const MeasuredInstances& instances;
  std::span<const Pose> object_in_world;  // by World::objects
  Pose sonar_in_world;
  const ImageRuns& polar;                       // instance_runs
  std::span<const float> clean_power_pa2;       // [beams x samples]
  std::span<const Annotation> polar_instances;  // annotations of `polar`
};

// Measures by instance id, without numbers for instances that have no pixel in the polar image.
std::vector<InstanceMeasures> instance_measures(const MeasuredPing& ping);

}  // namespace ensonify
