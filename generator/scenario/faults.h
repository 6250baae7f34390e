// All errors of a scenario, collected so that one run reports them together.
//
//   Place   a source (file, preset, --set) with line and column
//   ReadLimits  how much a text may hold
//   Faults  add_source  add_fault  needs_words
//   ErrorPlaces  to_error
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
  std::string path;  // of keys, such as objects.0.name; empty: the whole text
  std::string text;  // what is wrong and what is expected
};

// Limits far above real scenarios, so that a hostile one ends with an error: 65,534 objects with
// every key take about 1.2 million values in 10 MB. Fuzzers lower the limits, because a second in
// the program takes twenty seconds under sanitizers.
struct ReadLimits {
  std::size_t values = 2'000'000;        // of a YAML text, and those that counts of objects produce
  std::size_t copied_values = 250'000;   // by anchors and aliases
  std::size_t counted_values = 500'000;  // that the counts of all axes of a sweep produce
};

struct Faults {
  ReadLimits limits;
  std::vector<std::string> sources;  // labels: a file's name, `--set KEY.PATH`, `preset NAME`
  std::vector<Fault> list;
  std::size_t left_out = 0;  // found after the list was full
  std::size_t repeated = 0;  // for values with the same text: reported once

  bool empty() const { return list.empty(); }
  // Grows with every error, reported or not.
  std::size_t found() const { return list.size() + left_out + repeated; }
};

// At most this many errors are listed; further ones are only counted.
inline constexpr std::size_t kMaxFaults = 100;

int add_source(Faults& faults, std::string label);

// One text in the file may stand for many values, by a count or an anchor. An error that differs
// from a listed one only in the numbers of list items is not listed again.
void add_fault(Faults& faults, Place place, std::string_view path, std::string text);

// Check before a text that is expensive to build: returns false, and counts the error, if the list
// is full or already has an error at that place and path (numbers of items aside).
bool needs_words(Faults& faults, Place place, std::string_view path);

enum class ErrorPlaces {
  shown,   // `file:line:column: key.path: ...`, in the order of the sources and places
  hidden,  // `key.path: ...`, in the order of the paths: the same for every copy of a scenario
};

// One line per error, `file:line:column: key.path: what is wrong; expected what would be right`,
// without repeated lines.
Error to_error(const Faults& faults, ErrorPlaces places = ErrorPlaces::shown);

}  // namespace ensonify
