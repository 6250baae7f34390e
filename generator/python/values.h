// C++ values as Python objects.
//
//   OutputFlag  kOutputFlags   the members of OutputSelection that the package knows, by name
//   selection_of  flags_of
//   dict_of    a resolved scenario
//   error_of   an Error as the exception of its kind
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "core/error.h"
#include "core/ping.h"

namespace ensonify::python {

struct OutputFlag {
  const char* name;
  bool OutputSelection::*member;
};

inline constexpr OutputFlag kOutputFlags[] = {
    {"timeseries", &OutputSelection::timeseries},
    {"timeseries_exr", &OutputSelection::timeseries_exr},
    {"polar", &OutputSelection::polar},
    {"cartesian", &OutputSelection::cartesian},
    {"cartesian_exr", &OutputSelection::cartesian_exr},
    {"png", &OutputSelection::png},
    {"shadow", &OutputSelection::shadow},
    {"amodal", &OutputSelection::amodal},
    {"multipath", &OutputSelection::multipath},
    {"surfaces", &OutputSelection::surfaces},
    {"front", &OutputSelection::front},
    {"motion", &OutputSelection::motion},
    {"elevation", &OutputSelection::elevation},
    {"layers", &OutputSelection::layers},
    {"channels", &OutputSelection::channels},
};

// `base` with only the named flags; outputs that exist only as files are off.
OutputSelection selection_of(const OutputSelection& base, const std::vector<std::string>& flags);
// The names of the flags that are on.
std::vector<std::string> flags_of(const OutputSelection& selection);

// Converts the text of to_yaml to dict, list, str, int, float, bool and None.
pybind11::object dict_of(const std::string& yaml);

// Raises the error: ensonify's ScenarioError (usage), OSError (io), KeyboardInterrupt (interrupted)
// or RuntimeError (others).
[[noreturn]] void raise(const Error& error);

}  // namespace ensonify::python
