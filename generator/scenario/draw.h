// Sampling: distributions and counts in the tree of a scenario become plain values before the
// sections are read. A random number is keyed by its key path, in which items of lists are named,
// so that it does not change when other objects are added, removed or reordered.
//
//   is_distribution     {uniform: [a, b]}, {log_uniform: ...}, {normal: ...}, {choice: [...]}
//   holds_distribution  anywhere in a tree
//   is_head_key         keys of the top level that key the random numbers and are not sampled
//   is_counted_list     objects and point_targets
//   has_counts          whether a section has entries that stand for several
//   distribution_trouble  whole_number  without_choices
//   draw_values         the tree of one sequence
//   Copies  name_parents
//   DrawExtreme  draw_extremes  draw_variants   the trees at the extremes of the distributions
//
// Sections with distributions, counts or uses of variables keep their text in the resolved
// scenario, as `variables` does, so that it samples the same values again.
//
//   keep_drawn_sections   from the tree merged with presets, with resolved input files
//   drawn_section  section_text
//   flow_text             a tree as YAML on one line
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/random.h"
#include "scenario/faults.h"
#include "scenario/field_reader.h"
#include "scenario/field_writer.h"
#include "scenario/scenario.h"
#include "scenario/variables.h"
#include "scenario/yaml_tree.h"

namespace ensonify {

bool is_distribution(const Node& node);
bool holds_distribution(const Node& node);
bool is_head_key(std::string_view key);
bool is_counted_list(std::string_view path);
bool has_counts(std::string_view section, const Node& node);

// The error in the two numbers of a distribution of this kind; empty if they are valid.
std::string distribution_trouble(std::string_view kind, const std::array<double, 2>& given);

// A number without a fraction that a double can represent.
std::optional<std::int64_t> whole_number(const Node& node);

// The path of the value that a choice replaces, without `.choice.NUMBER`.
std::string without_choices(std::string path);

// Replaces every distribution below the keys of the top level, and every use of a variable
// (variables.h), by its value, and removes `variables`. A wrong distribution stays as it is; its
// places are added to `wrong`, so that later errors there can be dropped.
void draw_values(Node& root, std::uint64_t seed, SequenceDraw draw, Faults& faults,
                 std::vector<Place>& wrong, std::vector<VariableUse>& uses,
                 std::vector<DrawnValue>& draws);

// Sets every number to one end of its distribution (for a normal one: 3 standard deviations from
// the mean, which one sample in 370 exceeds), and every choice to one alternative. The variants 0
// ... draw_variants - 1 contain each alternative at least once.
struct DrawExtreme {
  bool is_upper = false;
  std::size_t variant = 0;
};
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

std::size_t draw_variants(const Node& root);
std::size_t variants_of_choice(const Node& alternatives);  // the list of a choice

struct DrawnSection {
  std::string key;  // of the top level
  Node tree;        // values of file keys are complete paths
};

struct DrawnSections {
  std::vector<DrawnSection> list;
};

// Null if nothing is sampled or counted. Error: an input file of any alternative does not exist.
std::shared_ptr<const DrawnSections> keep_drawn_sections(const Node& root,
                                                         const InputFolder& input);

// The tree of a section; null if the section is not sampled.
const Node* drawn_section(const Scenario& scenario, std::string_view key);

std::string section_text(std::string_view key, const Node& tree, const NameFile& name_file);

// The text reads back to the same tree.
std::string flow_text(const Node& node);

}  // namespace ensonify
