// Fills structs from a tree according to their fields.
//
//   InputFolder  MaterialNames   targets of references in a scenario
//   FieldReader                  errors, the current map, and the functions of Fields
//   ReadWatch                    whether a part was read without errors
#pragma once

#include <deque>
#include <filesystem>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "scenario/fields.h"

namespace ensonify {

// The folder of input files, and the list for errors about them.
struct InputFolder {
  std::filesystem::path folder;
  Faults& faults;
};

// The materials that objects can refer to.
struct MaterialNames {
  std::unordered_set<std::string_view> set;
  std::vector<std::string_view> list;
};

class FieldReader : public Fields {
 public:
  FieldReader(const InputFolder& input, const Value& map);

  Faults& faults() const { return input_.faults; }
  const Value& map() const { return frames_.back().value; }
  const InputFolder& input() const { return input_; }
  MaterialNames materials;

  // Continues in this tree instead of the current map.
  void replace_map(Node tree);

  bool writing() const override { return false; }
  FieldReader* reader() override { return is_mute() ? nullptr : this; }
  bool leaf(const KeyText& key, const Leaf& leaf, const Rule& rule) override;
  bool begin(const KeyText& key, const Branch& branch, const Rule& rule) override;
  void end() override;
  std::optional<std::size_t> only_key(std::span<const std::string_view> keys, std::size_t held,
                                      std::string_view what, Need need) override;
  void renamed(std::string_view before, std::string_view today) override;
  void fault(std::string_view key, std::string text) override;
  const Node* peek(std::string_view key) override;
  std::optional<std::size_t> peek_kind(std::string_view key,
                                       std::span<const std::string_view> words,
                                       std::size_t held) override;
  using Fields::begin;

 private:
  struct Frame {
    Value value;
    bool is_map = true;                     // its keys are known once they have been asked for
    bool is_read = false;                   // as a whole
    std::vector<std::string_view> known;    // keys
    std::vector<std::string_view> renamed;  // keys that are given under an earlier name
  };

  // A value that is not a map has no keys to read; these are collected only for the message.
  bool is_mute() const {
    return frames_.back().is_map && frames_.back().value.node->kind != NodeKind::map;
  }
  void know(std::string_view key);
  bool wants(std::string_view key, const Rule& rule);
  Need need_of(std::string_view key, const Rule& rule) const;

  InputFolder input_;
  std::vector<Frame> frames_;
  std::deque<Node> replaced_;
};

// Whether a map is being read, and no error has been found in it since.
class ReadWatch {
 public:
  explicit ReadWatch(Fields& f)
      : reader_(f.reader()), before_(reader_ != nullptr ? reader_->faults().found() : 0) {}
  bool is_well() const { return reader_ != nullptr && reader_->faults().found() == before_; }

 private:
  const FieldReader* reader_;
  std::size_t before_;
};

}  // namespace ensonify
