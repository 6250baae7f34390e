// What annotations say of an instance at a ping, whichever the image: how much of it is outside of
// the fan, and how far it stands out from the ground.
//
//   MeasuredInstances  measured_instances   what a world fixes
//   MeasuredPing  instance_measures          of one ping
#pragma once

#include <span>
#include <vector>

#include "app/session.h"
#include "core/ping.h"

namespace ensonify {

struct MeasuredInstances {
  std::vector<std::vector<Vec3>> surface_m;  // by World::objects: surface_samples
  // By instance id: the longest side of its box, infinite for planes, terrain and inward-facing
  // shapes, in which other things stand; 0 without a box.
  std::vector<double> size_m;
};

MeasuredInstances measured_instances(const World& world);

struct MeasuredPing {
  const Session& session;
  const MeasuredInstances& instances;
  std::span<const Pose> object_in_world;  // by World::objects
  Pose sonar_in_world;
  const LabelledImage& polar;
  std::span<const float> clean_power_pa2;       // [beams x samples]
  std::span<const Annotation> polar_instances;  // annotations of `polar`
};

// By instance id; of those without a pixel in the polar image without numbers.
std::vector<InstanceMeasures> instance_measures(const MeasuredPing& ping);

}  // namespace ensonify
