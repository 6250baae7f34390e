#include "python/values.h"

#include <algorithm>
#include <cstdlib>

#include "scenario/faults.h"
#include "scenario/text.h"
#include "scenario/yaml_tree.h"

namespace ensonify::python {
namespace py = pybind11;
namespace {

py::object number_of(const std::string& text) {
  const bool is_whole = text.find_first_not_of("+-0123456789") == std::string::npos;
  if (is_whole) return py::int_(py::str(text));
  return py::float_(std::strtod(text.c_str(), nullptr));
}

py::object scalar_of(const Node& node) {
  if (node.quoted) return py::str(node.text);
  switch (classify_plain(node.text)) {
    case PlainKind::number:
      return number_of(node.text);
    case PlainKind::boolean:
      return py::bool_(equals_ignoring_case(node.text, "true"));
    default:
      return py::str(node.text);
  }
}

py::object object_of(const Node& node) {
  switch (node.kind) {
    case NodeKind::null:
      return py::none();
    case NodeKind::scalar:
      return scalar_of(node);
    case NodeKind::list: {
      py::list list;
      for (const Node& item : node.items) list.append(object_of(item));
      return list;
    }
    case NodeKind::map:
      break;
  }
  py::dict dict;
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    dict[py::str(node.keys[i].text)] = object_of(node.items[i]);
  }
  return dict;
}

}  // namespace

OutputSelection selection_of(const OutputSelection& base, const std::vector<std::string>& flags) {
  OutputSelection selection = base;
  selection.scatterers = selection.points = selection.polygons = selection.packed =
      selection.covisibility = selection.world = false;
  for (const OutputFlag& flag : kOutputFlags) {
    selection.*flag.member =
        std::find(flags.begin(), flags.end(), flag.name) != flags.end() && base.*flag.member;
  }
  return selection;
}

std::vector<std::string> flags_of(const OutputSelection& selection) {
  std::vector<std::string> flags;
  for (const OutputFlag& flag : kOutputFlags) {
    if (selection.*flag.member) flags.emplace_back(flag.name);
  }
  return flags;
}

py::object dict_of(const std::string& yaml) {
  Faults faults;
  const std::optional<Node> tree = read_yaml_map(yaml, add_source(faults, "scenario"), faults);
  ENSONIFY_ASSERT(tree && faults.empty());
  return object_of(*tree);
}

void raise(const Error& error) {
  switch (error.kind) {
    case ErrorKind::interrupted:
      PyErr_SetNone(PyExc_KeyboardInterrupt);
      throw py::error_already_set();
    case ErrorKind::io:
      PyErr_SetString(PyExc_OSError, error.message.c_str());
      throw py::error_already_set();
    case ErrorKind::usage:
    case ErrorKind::final_usage:
    case ErrorKind::redraw:
    case ErrorKind::incomplete: {
      const py::object type = py::module_::import("ensonify.errors").attr("ScenarioError");
      PyErr_SetObject(type.ptr(), py::str(error.message).ptr());
      throw py::error_already_set();
    }
    default:
      throw std::runtime_error(error.message);
  }
}

}  // namespace ensonify::python
