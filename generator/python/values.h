// C++ values as Python objects.
//
//   selection_of  flags_of   outputs by the names of kOutputFlags (core/outputs.h)
//   dict_of    a resolved scenario
//   raise      an Error as the exception of its kind
//   bind_ping  the class Ping of the extension
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "core/error.h"
#include "core/outputs.h"

namespace ensonify::python {

// `base` with only the named flags; outputs that exist only as files are off.
OutputSelection selection_of(const OutputSelection& base, const std::vector<std::string>& flags);
// The names of the flags that are on.
std::vector<std::string> flags_of(const OutputSelection& selection);

// Converts the text of to_yaml to dict, list, str, int, float, bool and None.
pybind11::object dict_of(const std::string& yaml);

// Raises the error: ensonify's ScenarioError (usage), OSError (io), KeyboardInterrupt (interrupted)
// or RuntimeError (others).
[[noreturn]] void raise(const Error& error);

void bind_ping(pybind11::module_& module);

}  // namespace ensonify::python
