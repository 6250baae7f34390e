// Conditions over the values of a sweep's axes, read by muparser.
//
//   Conditions   made once, asked for many points
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"
#include "scenario/faults.h"

namespace ensonify {

class Conditions {
 public:
  // The variables.
  explicit Conditions(std::vector<std::string> names);
  ~Conditions();
  Conditions(const Conditions&) = delete;
  Conditions& operator=(const Conditions&) = delete;

  // What is wrong with it; nothing: it was added. Comparisons and &&, ||, !, arithmetic and
  // functions; no assignment, one value.
  std::optional<std::string> add(const std::string& text);

  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  struct Answer {
    std::size_t holds = none;     // index of the first condition that holds
    std::size_t no_value = none;  // of the first, if it comes before, that divides by zero, has a
                                  // root of what is below zero, or is not finite
  };
  // Values of the variables, in their order.
  Answer at(std::span<const double> values);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ensonify
