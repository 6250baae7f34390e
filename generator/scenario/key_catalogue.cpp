#include "scenario/key_catalogue.h"

#include <algorithm>
#include <set>

#include "core/error.h"
#include "scenario/field_writer.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

KeyNode& child_of(KeyNode& map, std::string_view key) {
  for (KeyNode& node : map.keys) {
    if (node.key == key) return node;
  }
  map.keys.emplace_back();
  map.keys.back().key = key;
  return map.keys.back();
}

void set_value(KeyNode& node, const NumberLeaf& leaf) {
  node.type = ValueType::number;
  node.range = leaf.range;
}
void set_value(KeyNode& node, const NumbersLeaf& leaf) {
  node.type = ValueType::numbers;
  node.range = leaf.range;
}
void set_value(KeyNode& node, const IntegerLeaf& leaf) {
  node.type = ValueType::integer;
  node.low = leaf.low;
  node.high = leaf.high;
}
void set_value(KeyNode& node, const SeedLeaf&) { node.type = ValueType::seed; }
void set_value(KeyNode& node, const BooleanLeaf&) { node.type = ValueType::boolean; }
void set_value(KeyNode& node, const TextLeaf& leaf) {
  node.type = ValueType::text;
  node.most_bytes = leaf.most_bytes;
}
void set_value(KeyNode& node, const MaterialLeaf&) { node.type = ValueType::material; }
void set_value(KeyNode& node, const FileLeaf& leaf) {
  node.type = ValueType::file;
  node.endings.assign(leaf.endings.begin(), leaf.endings.end());
}
void set_value(KeyNode& node, const WordLeaf& leaf) {
  node.type = ValueType::word;
  node.words.assign(leaf.words.begin(), leaf.words.end());
}

// Walks through the fields without a tree to read. Each visit to a choice takes the next
// alternative, so that repeated walks visit all of them.
class KeyLister : public Fields {
 public:
  explicit KeyLister(KeyNode& root) {
    frames_.push_back({&root, {}, 1});
    scalar_.kind = NodeKind::scalar;
    map_.kind = NodeKind::map;
    list_.kind = NodeKind::list;
  }

  bool writing() const override { return false; }

  bool leaf(const KeyText& text, const Leaf& leaf, const Rule& rule) override {
    KeyNode& node = text.key.empty() ? *frames_.back().node : note(text, rule);
    const auto* word = std::get_if<WordLeaf>(&leaf);
    if (node.unit.empty()) node.unit = text.unit;
    if (node.type == ValueType::none) {
      std::visit([&](const auto& l) { set_value(node, l); }, leaf);
      const bool has_default = rule.has_default && !std::holds_alternative<FileLeaf>(leaf);
      if (has_default && !text.key.empty()) node.default_text = leaf_text(leaf);
    }
    if (const auto* numbers = std::get_if<NumbersLeaf>(&leaf)) node.count = numbers->out.size();
    if (word == nullptr) return false;
    word->index = next(text.key, word->words.size());
    if (!rule.useless.empty()) return false;
    happens(text.key, word->words[word->index]);
    return true;
  }

  bool begin(const KeyText& text, const Branch& branch, const Rule& rule) override {
    KeyNode* node = &note(text, rule);
    if (const auto* list = std::get_if<ListBranch>(&branch)) {
      list->count = 1;
      node->is_list = true;
      node->least = list->words.least;
      node->most = list->words.most;
    } else if (const auto* names = std::get_if<NamesBranch>(&branch)) {
      names->names = {"*"};
      node->has_names = true;
    } else if (const auto* kind = std::get_if<KindBranch>(&branch)) {
      node = &enter_kind(*node, *kind, rule);
    } else if (const auto* switched = std::get_if<SwitchBranch>(&branch)) {
      if (!node->is_switch && rule.has_default) {
        node->default_text = switched->on ? "true" : "false";
      }
      node->is_switch = true;
      switched->on = true;
    } else {
      node->is_map = true;
    }
    frames_.push_back({node, {}, 1});
    return true;
  }
  void end() override { frames_.pop_back(); }

  std::optional<std::size_t> only_key(std::span<const std::string_view> keys, std::size_t,
                                      std::string_view, Need need) override {
    std::vector<KeyGroup>& groups = frames_.back().node->groups;
    KeyGroup group{{keys.begin(), keys.end()}, need == Need::required};
    const auto known = std::find_if(groups.begin(), groups.end(), [&](const KeyGroup& other) {
      return other.keys == group.keys;
    });
    if (known == groups.end()) {
      for (const std::string_view key : keys) child_of(*frames_.back().node, key);
      groups.push_back(std::move(group));
    } else {
      known->is_required = known->is_required && need == Need::required;
    }
    const std::size_t index = next(std::string(keys[0]) + " or another", keys.size());
    happens(keys[index], "");
    return index;
  }
  const Node* peek(std::string_view key) override {
    const Node* const found[] = {nullptr, &scalar_, &map_, &list_};
    const std::size_t index = next(key, std::size(found));
    if (index > 0) happens(key, "");
    return found[index];
  }
  std::optional<std::size_t> peek_kind(std::string_view key,
                                       std::span<const std::string_view> words,
                                       std::size_t) override {
    const std::size_t index = next(key, words.size());
    happens(key, words[index]);
    return index;
  }
  void describe_count(const KeyText& text, int low, int high) override {
    int one = 1;
    leaf(text, IntegerLeaf{one, low, high}, {});
  }

 private:
  struct Frame {
    KeyNode* node = nullptr;
    std::vector<KeyNode::Circumstance> circumstances;
    std::size_t combinations = 1;  // of the choices visited so far
  };

  // Enumerates the combinations of a map's choices, as the digits of one number.
  std::size_t next(std::string_view key, std::size_t count) {
    Frame& frame = frames_.back();
    KeyNode::Turns& turns = frame.node->turns.try_emplace(std::string(key)).first->second;
    const std::size_t index = turns.visits++ / frame.combinations % count;
    frame.combinations *= count;
    turns.alternatives = count;
    turns.seen.insert(index);
    return index;
  }

  void happens(std::string_view key, std::string_view word) {
    frames_.back().circumstances.emplace_back(key, word);
  }

  KeyNode& note(const KeyText& text, const Rule& rule) {
    KeyNode& map = *frames_.back().node;
    KeyNode& node = child_of(map, map.is_list || map.has_names ? "*" : text.key);
    if (node.title.empty()) {
      node.title = text.title;
      node.meaning = text.meaning;
      node.unit = text.unit;
    }
    node.unless = rule.unless;
    const auto count = [&](KeyNode::Visits& visits) {
      ++visits.all;
      if (!rule.useless.empty()) ++visits.useless;
      if (rule.useless.empty() && rule.need == Need::required) ++visits.needed;
    };
    count(node.visits);
    for (const auto& circumstance : frames_.back().circumstances) {
      if (circumstance.first != text.key) count(node.visits_with[circumstance]);
    }
    return node;
  }

  KeyNode& enter_kind(KeyNode& node, const KindBranch& kind, const Rule& rule) {
    if (!node.is_kind) {
      node.is_kind = true;
      node.words.assign(kind.words.begin(), kind.words.end());
      node.kinds.assign(kind.texts.begin(), kind.texts.end());
      node.groups.push_back({node.words, true});
      if (rule.has_default) node.default_text = kind.words[kind.index];
      for (const std::string_view word : kind.words) child_of(node, word).is_map = true;
    }
    kind.index = next(node.key, kind.words.size());
    happens(node.key, kind.words[kind.index]);
    return child_of(node, kind.words[kind.index]);
  }

  std::vector<Frame> frames_;
  Node scalar_, map_, list_;  // what peek may return
};

bool has_seen_all(const KeyNode& map) {
  const auto seen = [](const auto& turns) {
    return turns.second.seen.size() == turns.second.alternatives;
  };
  return std::all_of(map.turns.begin(), map.turns.end(), seen) &&
         std::all_of(map.keys.begin(), map.keys.end(), has_seen_all);
}

// Derives the rules for the keys of each map from the visits of all walks.
void settle(KeyNode& map) {
  const auto in_group = [&](const KeyNode& node) {
    return std::any_of(map.groups.begin(), map.groups.end(), [&](const KeyGroup& group) {
      return std::find(group.keys.begin(), group.keys.end(), node.key) != group.keys.end();
    });
  };
  // Keys that are asked for only in order to be refused.
  std::erase_if(map.keys, [](const KeyNode& node) {
    return node.visits.all > 0 && node.visits.useless == node.visits.all;
  });
  for (KeyNode& node : map.keys) {
    const KeyNode::Visits& visits = node.visits;
    for (const auto& [circumstance, with] : node.visits_with) {
      if (with.useless < with.all) continue;
      map.exclusions.push_back({node.key, circumstance.first, circumstance.second});
    }
    const bool needed = visits.needed > 0 && visits.needed == visits.all - visits.useless;
    if (needed && !in_group(node)) {
      (visits.useless > 0 ? node.is_required_alone : node.is_required) = true;
    }
    settle(node);
  }
}

KeyNode walked_tree() {
  constexpr int kMostWalks = 10'000;
  KeyNode root;
  for (int walk = 0; walk == 0 || !has_seen_all(root); ++walk) {
    ENSONIFY_ASSERT(walk < kMostWalks);
    Scenario scenario;
    KeyLister lister(root);
    fields(lister, scenario);
  }
  root.is_map = true;
  settle(root);
  return root;
}

}  // namespace

const KeyNode& key_tree() {
  static const KeyNode tree = walked_tree();
  return tree;
}

const KeyNode* find_key(const KeyNode& map, std::string_view key) {
  const auto found = std::find_if(map.keys.begin(), map.keys.end(),
                                  [&](const KeyNode& node) { return node.key == key; });
  return found == map.keys.end() ? nullptr : &*found;
}

}  // namespace ensonify
