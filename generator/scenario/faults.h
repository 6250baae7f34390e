// Everything that is wrong with a scenario, collected so that it can be told at once.
//
//   Place   where: a source (file, preset, --set) with line and column
//   Faults  add_source  add_fault  to_error
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace ensonify {

// Line and column count from 1, columns in characters; line 0: the source has no lines (--set).
struct Place {
  int source = 0;
  int line = 0;
  int column = 0;
};

struct Fault {
  Place place;
  std::string path;  // of keys, as objects.0.name; empty: the whole text
  std::string text;  // what is wrong, what is accepted
};

struct Faults {
  std::vector<std::string> sources;  // labels: a file's name, `--set KEY.PATH`, `preset NAME`
  std::vector<Fault> list;
  std::size_t left_out = 0;  // found after the list was full

  bool empty() const { return list.empty(); }
};

// More than this nobody reads; the rest is counted only.
inline constexpr std::size_t kMaxFaults = 100;

int add_source(Faults& faults, std::string label);
void add_fault(Faults& faults, Place place, std::string_view path, std::string text);

// One line a fault, `file:line:column: key.path: what is wrong, what is accepted`, in the order of
// the sources and of the places within them, each line once, and each fault of a text that stands
// for several values.
Error to_error(const Faults& faults);

}  // namespace ensonify
