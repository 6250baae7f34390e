#include "scenario/key_catalogue.h"

#include <functional>
#include <map>
#include <set>
#include <string>

#include "scenario/sections.h"

namespace ensonify {
namespace {

using Keys = std::set<std::string, std::less<>>;

struct KeyNode {
  bool is_whole = false, is_kind = false, has_names = false, is_list = false;
  std::map<std::string, KeyNode, std::less<>> keys;  // one for all items and all names
  std::size_t visits = 0, peeks = 0;
};

struct ValueExclusion {
  std::string key, word;
  Keys excluded;
};

struct Catalogue {
  KeyNode root;
  std::map<std::string, Keys, std::less<>> excluded;
  std::vector<ValueExclusion> by_value;
  Keys files;
};

// Walks through the fields without anything to read. Each visit to a choice takes the next
// alternative, so that many walks have seen them all.
class KeyLister : public Fields {
 public:
  explicit KeyLister(Catalogue& catalogue) : catalogue_(catalogue) {
    frames_.push_back({&catalogue.root, "", "", ""});
  }

  bool writing() const override { return false; }
  bool leaf(std::string_view key, const Leaf& leaf, const Rule& rule) override {
    if (key.empty()) return false;
    KeyNode& node = note(key, rule);
    node.is_whole = std::holds_alternative<IntegerLeaf>(leaf);
    if (std::holds_alternative<FileLeaf>(leaf)) catalogue_.files.emplace(key);
    const auto* word = std::get_if<WordLeaf>(&leaf);
    if (word == nullptr) return false;
    word->index = next(node, word->words.size());
    if (!rule.useless.empty()) return false;
    frames_.back().key = key;
    frames_.back().word = word->words[word->index];
    return true;
  }

  bool begin(std::string_view key, const Branch& branch, const Rule& rule) override {
    KeyNode* node = &note(key, rule);
    if (const auto* list = std::get_if<ListBranch>(&branch)) {
      list->count = 1;
      node->is_list = true;
    } else if (const auto* names = std::get_if<NamesBranch>(&branch)) {
      names->names = {"*"};
      node->has_names = true;
    } else if (const auto* kind = std::get_if<KindBranch>(&branch)) {
      node->is_kind = true;
      exclude_each_other(kind->words);
      kind->index = next(*node, kind->words.size());
      node = &node->keys[std::string(kind->words[kind->index])];
    } else if (const auto* switched = std::get_if<SwitchBranch>(&branch)) {
      switched->on = true;
    }
    frames_.push_back({node, "", "", ""});
    return true;
  }
  void end() override { frames_.pop_back(); }

  std::optional<std::size_t> only_key(std::span<const std::string_view> keys, std::size_t,
                                      std::string_view, Need) override {
    exclude_each_other(keys);
    const std::size_t index = next(*frames_.back().node, keys.size());
    // What is of no effect beside one of many may well be so beside others.
    frames_.back().chosen = keys.size() == 2 ? keys[index] : "";
    return index;
  }
  const Node* peek(std::string_view key) override {
    static const Node something;
    if (child(key).peeks++ % 2 == 0) return nullptr;
    frames_.back().chosen = key;
    return &something;
  }
  std::optional<std::size_t> peek_kind(std::string_view key,
                                       std::span<const std::string_view> words,
                                       std::size_t) override {
    const std::size_t index = next(child(key), words.size());
    frames_.back().key = key;
    frames_.back().word = words[index];
    return index;
  }

 private:
  struct Frame {
    KeyNode* node = nullptr;
    std::string chosen;     // among keys that exclude each other
    std::string key, word;  // the last word, of which key
  };

  static std::size_t next(KeyNode& node, std::size_t count) { return node.visits++ % count; }

  KeyNode& child(std::string_view key) {
    KeyNode& node = *frames_.back().node;
    return node.keys[node.is_list || node.has_names ? "*" : std::string(key)];
  }

  KeyNode& note(std::string_view key, const Rule& rule) {
    const Frame& frame = frames_.back();
    if (!rule.useless.empty() && !frame.chosen.empty()) exclude(frame.chosen, key);
    if (!rule.useless.empty() && !frame.word.empty()) exclude_by_value(frame, key);
    return child(key);
  }

  void exclude(std::string_view one, std::string_view other) {
    catalogue_.excluded[std::string(one)].emplace(other);
    catalogue_.excluded[std::string(other)].emplace(one);
  }

  void exclude_each_other(std::span<const std::string_view> keys) {
    for (const std::string_view one : keys) {
      for (const std::string_view other : keys) {
        if (one != other) exclude(one, other);
      }
    }
  }

  void exclude_by_value(const Frame& frame, std::string_view key) {
    for (ValueExclusion& exclusion : catalogue_.by_value) {
      if (exclusion.key != frame.key || exclusion.word != frame.word) continue;
      exclusion.excluded.emplace(key);
      return;
    }
    catalogue_.by_value.push_back({frame.key, frame.word, {std::string(key)}});
  }

  Catalogue& catalogue_;
  std::vector<Frame> frames_;
};

const Catalogue& catalogue() {
  static const Catalogue made = [] {
    // Eight shapes, of which terrain has two sources, and some to spare.
    constexpr int kWalks = 40;
    Catalogue listed;
    for (int walk = 0; walk < kWalks; ++walk) {
      Scenario scenario;
      KeyLister lister(listed);
      fields(lister, scenario);
    }
    return listed;
  }();
  return made;
}

const KeyNode* node_at(std::span<const std::string_view> path) {
  const KeyNode* node = &catalogue().root;
  for (const std::string_view segment : path) {
    const auto found =
        node->keys.find(node->is_list || node->has_names ? std::string_view("*") : segment);
    if (found == node->keys.end()) return nullptr;
    node = &found->second;
  }
  return node;
}

}  // namespace

std::vector<std::string_view> excluded_by(std::string_view key) {
  const auto found = catalogue().excluded.find(key);
  if (found == catalogue().excluded.end()) return {};
  return {found->second.begin(), found->second.end()};
}

std::vector<std::string_view> excluded_by_value(std::string_view key, const Node& value) {
  std::vector<std::string_view> excluded;
  for (const ValueExclusion& exclusion : catalogue().by_value) {
    if (exclusion.key != key) continue;
    if (value.text != exclusion.word && find(value, exclusion.word) == nullptr) continue;
    excluded.insert(excluded.end(), exclusion.excluded.begin(), exclusion.excluded.end());
  }
  return excluded;
}

bool names_file(std::string_view key) { return catalogue().files.contains(key); }

bool reads_whole_numbers(std::string_view path) {
  std::vector<std::string_view> segments;
  for (;;) {
    const std::size_t dot = path.find('.');
    segments.push_back(path.substr(0, dot));
    if (dot == std::string_view::npos) break;
    path.remove_prefix(dot + 1);
  }
  const bool counted = segments.size() == 3 && segments[2] == "count" &&
                       (segments[0] == "objects" || segments[0] == "point_targets");
  const KeyNode* node = node_at(segments);
  return counted || (node != nullptr && node->is_whole);
}

bool holds_kind(std::span<const std::string_view> path) {
  const KeyNode* node = node_at(path);
  return node != nullptr && node->is_kind;
}

bool holds_names(std::span<const std::string_view> path) {
  const KeyNode* node = node_at(path);
  return node != nullptr && node->has_names;
}

}  // namespace ensonify
