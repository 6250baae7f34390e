// Values that are drawn: distributions and counts in the tree of a scenario become plain values,
// before the sections are read. A draw is keyed by its key path, in which items of lists stand by
// their name, so that it stays when other objects come, go or change places.
//
//   is_distribution     {uniform: [a, b]}, {log_uniform: ...}, {normal: ...}, {choice: [...]}
//   holds_distribution  anywhere in a tree
//   is_head_key         of the top level, which key the draws of the rest and are not drawn
//   is_counted_list     objects and point_targets
//   has_counts          entries of them that stand for several
//   distribution_trouble  whole_number  without_choices
//   draw_values         the tree of one sequence
//   Copies  name_parents
//   DrawExtreme  draw_extremes  draw_variants   the trees at the ends of what can be drawn
//
// Sections that hold distributions, counts or uses of variables, and `variables`, stay in the resolved text as they were before drawing,
// so that it draws the same again.
//
//   keep_drawn_sections   from the merged tree, presets laid under, input files resolved
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

// What is wrong with the two numbers of a distribution of that kind; empty: nothing.
std::string distribution_trouble(std::string_view kind, const std::array<double, 2>& given);

// A number without a fraction that a double holds.
std::optional<std::int64_t> whole_number(const Node& node);

// The path of what a choice stands for: without `.choice.NUMBER`.
std::string without_choices(std::string path);

// Replaces every distribution below the top level's keys, and every use of a variable (variables.h)
// by its value; takes `variables` away. What is wrong stays as it is; its places are added to
// `wrong`, so that what is said about it later can be left out.
void draw_values(Node& root, std::uint64_t seed, SequenceDraw draw, Faults& faults,
                 std::vector<Place>& wrong, std::vector<VariableUse>& uses,
                 std::vector<DrawnValue>& draws);

// Every number at one end of what its distribution can give (of a normal: 3 standard deviations
// from its mean, which one draw in 370 exceeds), and of every choice one alternative. The variants
// 0 ... draw_variants - 1 have each alternative at least once.
struct DrawExtreme {
  bool is_upper = false;
  std::size_t variant = 0;
};
void draw_extremes(Node& root, const DrawExtreme& extreme, Faults& faults,
                   std::vector<Place>& wrong, std::vector<VariableUse>& uses);
// Objects first, first + 1, ... of the list are copies of an entry of that name.
struct Copies {
  std::string name;
  int count = 0;
  std::size_t first = 0;
};

// Parents that are entries with counts, which come in the order of the list, become their copies of
// the same number. A fault: other counts.
void name_parents(Node& objects, const std::vector<Copies>& copies, Faults& faults);

std::size_t draw_variants(const Node& root);
std::size_t variants_of_choice(const Node& alternatives);  // the list of a choice

struct DrawnSection {
  std::string key;  // of the top level
  Node tree;        // values of file keys are whole paths
};

struct DrawnSections {
  std::vector<DrawnSection> list;
};

// Null where nothing is drawn or counted. Faults: input files of any alternative that are not
// there.
std::shared_ptr<const DrawnSections> keep_drawn_sections(const Node& root,
                                                         const InputFolder& input);

// The tree of a section; null if it is not drawn.
const Node* drawn_section(const Scenario& scenario, std::string_view key);

std::string section_text(std::string_view key, const Node& tree, const NameFile& name_file);

// Reads back to the same tree.
std::string flow_text(const Node& node);

}  // namespace ensonify
