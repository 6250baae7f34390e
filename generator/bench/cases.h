// What is timed: fixed sonars over one fixed world that needs no file.
//
//   BenchCase         bench_cases
//   make_bench_world  sea floor of 103,000 triangles with boxes, cylinders and spheres on it
//   bench_pose        where the sonar is
#pragma once

#include <string>
#include <vector>

#include "core/sonar.h"
#include "world/world.h"

namespace ensonify {

struct BenchCase {
  std::string name;
  Sonar sonar;
  Water water;
};

//   full     512 beams x 114 rays, 60 m, b = 29.9 kHz, 90 deg: Choi et al. 2021 as released
//   table1   the same with b = 2.95 kHz: Table 1 as printed
//   reduced  512 beams x 11 rays, 10 m
//   dense    512 beams x (912 x 8) rays, 60 m
//   array    full, heard by 256 elements at half a wavelength and focused at every sample
std::vector<BenchCase> bench_cases();

// Scaled to the range, so that hits lie in all of the record whatever the case.
World make_bench_world(double range_max_m);

// Nose down by half a fan of 20 deg: the highest rays are level.
Pose bench_pose();

}  // namespace ensonify
