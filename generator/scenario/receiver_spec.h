// sonar.receiver of a scenario, as far as it is an array of elements.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/sonar.h"

namespace ensonify {

// What is absent follows from the rest of the sonar and the water: app/array_receiver.h.
struct ArraySpec {
  std::optional<int> elements;
  std::optional<double> spacing_m;
  double element_width_m = 0;
  std::optional<BeamShading> shading;
  Focus focus = Focus::dynamic;
  Steering steering = Steering::true_delay;
  double gain_error_db = 0;    // standard deviation over elements
  double phase_error_deg = 0;  // likewise
  std::vector<int> dead;       // indices
};

inline constexpr int kMaxElements = 4096;

// What is wrong with the indices of dead elements, and what is accepted; empty: nothing.
std::string dead_trouble(const std::vector<int>& dead, int elements);

}  // namespace ensonify
