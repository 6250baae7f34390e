// Writes the resolved text of a scenario from its fields.
//
//   leaf_text                    a single value
//   FieldWriter                  entries of the current map; sections with distributions as given
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenario/drawn_sections.h"
#include "scenario/fields.h"
#include "scenario/scenario.h"

namespace ensonify {

// Empty for a file, which needs a name first.
std::string leaf_text(const Leaf& leaf);

class FieldWriter : public Fields {
 public:
  FieldWriter(const Scenario& scenario, const NameFile& name_file);

  // The text that has been written on the top level.
  std::string text_of_scenario() const;

  bool writing() const override { return true; }
  bool leaf(const KeyText& key, const Leaf& leaf, const Rule& rule) override;
  bool begin(const KeyText& key, const Branch& branch, const Rule& rule) override;
  void end() override;
  std::optional<std::size_t> only_key(std::span<const std::string_view>, std::size_t held,
                                      std::string_view, Need) override {
    return held;
  }
  using Fields::begin;

 private:
  enum class Form { map, list, names, kind, on };  // as the alternatives of Branch
  struct Entry {
    std::string key;   // empty: an item of a list, or a whole section with its key
    std::string text;  // after a line feed if it has its own lines
  };
  struct Frame {
    std::string key;  // the key of this frame in the frame below
    Form form = Form::map;
    bool in_lines = false;
    std::string word;  // of a kind
    std::vector<Entry> entries;
  };

  bool wants(std::string_view key, const Rule& rule);
  void put(std::string_view key, std::string text);
  std::string text_of(const Frame& frame) const;

  const Scenario& scenario_;
  const NameFile& name_file_;
  std::vector<Frame> frames_;
};

}  // namespace ensonify
