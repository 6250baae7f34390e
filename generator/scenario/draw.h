// Sampling: distributions and counts in the tree of a scenario become plain values before the
// sections are read. A random number is keyed by its key path, in which items of lists are named,
// so that it does not change when other objects are added, removed or reordered.
//
//   draw_values         the tree of one sequence
//   Copies  name_parents
//   DrawExtreme  draw_extremes   the trees at the extremes of the distributions
//   is_sampled       whether a text has distributions
//   first_readable   the scenario of the first sequence whose sampled values agree
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/random.h"
#include "scenario/faults.h"
#include "scenario/keyed_numbers.h"
#include "scenario/scenario.h"
#include "scenario/variables.h"
#include "scenario/yaml_tree.h"

namespace ensonify {

// Replaces every distribution below the keys of the top level, and every use of a variable
// (variables.h), by its value, and removes `variables`. A wrong distribution stays as it is; its
// places are added to `wrong`, so that later errors there can be dropped.
void draw_values(Node& root, std::uint64_t seed, SequenceDraw draw, Faults& faults,
                 std::vector<Place>& wrong, std::vector<VariableUse>& uses,
                 std::vector<DrawnValue>& draws);

// Sets every number to one end of its distribution (for a normal one: 3 standard deviations from
// the mean, which one sample in 370 exceeds), and every choice to one alternative. The variants 0
// ... draw_variants - 1 (distribution.h) contain each alternative at least once.
void draw_extremes(Node& root, const DrawExtreme& extreme, Faults& faults,
                   std::vector<Place>& wrong, std::vector<VariableUse>& uses);

// The objects first, first + 1, ... of the list are copies of an entry of that name.
struct Copies {
  std::string name;
  int count = 0;
  std::size_t first = 0;
};

// Replaces a parent that is an entry with a count by its copy with the same number. Entries are in
// the order of the list. Error: the counts differ.
void name_parents(Node& objects, const std::vector<Copies>& copies, Faults& faults);

// Whether an error of parse_scenario may come from the values that one sequence samples.
bool is_sampled(const std::string& text, const std::vector<Override>& overrides);

// An error that this many sequences have in the same words, from sequence 0 on, is one of the
// scenario.
inline constexpr std::uint32_t kMostAlike = 32;

// What `read(sequence)` returns for sequence 0 or, if its sampled values contradict each other, for
// the next of the first kMostAlike for which it succeeds. Error: that of sequence 0.
template <class Read>
auto first_readable(bool sampled, const Read& read) {
  auto first = read(0);
  for (std::uint32_t sequence = 1; !first && sampled && sequence < kMostAlike; ++sequence) {
    auto next = read(sequence);
    if (next) return next;
  }
  return first;
}

}  // namespace ensonify
