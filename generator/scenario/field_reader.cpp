#include "scenario/field_reader.h"

#include <algorithm>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "scenario/known_materials.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

std::vector<std::string_view> as_vector(std::span<const std::string_view> words) {
  return {words.begin(), words.end()};
}

// Reads an output that is off, on, or on with options, and returns the options.
std::optional<Value> read_switch(Faults& faults, const Value& map, std::string_view key,
                                 bool& out) {
  const auto value = child(map, key);
  if (!value) return std::nullopt;
  const Node& node = *value->node;
  if (node.kind == NodeKind::map) {
    out = true;
    return value;
  }
  const bool plain = node.kind == NodeKind::scalar && !node.quoted;
  if (plain && (node.text == "true" || node.text == "on")) {
    out = true;
  } else if (plain && (node.text == "false" || node.text == "off")) {
    out = false;
  } else {
    wrong_kind(faults, *value, "true (on), false (off) or a map of options");
  }
  return std::nullopt;
}

// One of several kinds, each with options of its own.
struct Kind {
  std::string_view word;
  Value options;  // any node: whoever opens it knows the valid keys
};

// A map of exactly one of `words`, such as {lfm: {duration_s: 1e-3}}. A word alone stands for a map
// of it without options.
std::optional<Kind> read_kind(Faults& faults, const Value& map, std::string_view key,
                              const std::vector<std::string_view>& words) {
  const auto value = child(map, key);
  if (!value) return std::nullopt;
  if (value->node->kind != NodeKind::map) {
    const auto index = read_word(faults, map, key, words, Need::optional);
    if (!index) return std::nullopt;
    return Kind{words[*index], child_or_empty(*value, words[*index])};
  }
  open_map(faults, *value, words);
  const bool any = std::any_of(words.begin(), words.end(), [&](std::string_view word) {
    return find(*value->node, word) != nullptr;
  });
  // A mistyped kind has been reported already.
  if (!any && !value->node->keys.empty()) return std::nullopt;
  const auto word = only_key_of(faults, *value, words, "one of " + joined(words));
  if (!word) return std::nullopt;
  return Kind{*word, *child(*value, *word)};
}

// What is wrong with an input file; empty if nothing is.
std::string_view file_trouble(const std::filesystem::path& file,
                              std::initializer_list<std::string_view> endings) {
  const std::string extension = file.extension().string();
  if (std::none_of(endings.begin(), endings.end(), [&](std::string_view accepted) {
        return equals_ignoring_case(extension, accepted);
      })) {
    return "has another extension";
  }
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) return "does not exist";
  if (std::filesystem::is_directory(status)) return "is a folder";
  if (!std::filesystem::is_regular_file(status)) return "is not a regular file";
  if (!std::ifstream(file).good()) return "cannot be read";
  return "";
}

// Leaves: return whether the value was set.

bool read(FieldReader& reader, std::string_view key, const NumberLeaf& leaf, Need need) {
  return read_number(reader.faults(), reader.map(), key, leaf.range, leaf.out, need);
}

bool read(FieldReader& reader, std::string_view key, const NumbersLeaf& leaf, Need need) {
  return read_numbers(reader.faults(), reader.map(), key, leaf.range, leaf.out.data(),
                      leaf.out.size(), need);
}

bool read_own_numbers(Faults& faults, const Value& value, const NumbersLeaf& leaf) {
  const bool bare_word = value.node->kind == NodeKind::map && value.node->keys.empty();
  if (!bare_word) {
    return read_numbers_of(faults, value, leaf.range, leaf.out.data(), leaf.out.size());
  }
  add_fault(faults, value.place, value.path,
            fmt::format("missing; expected a list of {} numbers", leaf.out.size()));
  return false;
}

bool read(FieldReader& reader, std::string_view key, const IntegerLeaf& leaf, Need need) {
  return read_integer(reader.faults(), reader.map(), key, leaf.low, leaf.high, leaf.out, need);
}

bool read(FieldReader& reader, std::string_view key, const SeedLeaf& leaf, Need) {
  return read_seed(reader.faults(), reader.map(), key, leaf.out);
}

bool read(FieldReader& reader, std::string_view key, const BooleanLeaf& leaf, Need) {
  return read_boolean(reader.faults(), reader.map(), key, leaf.out);
}

bool read(FieldReader& reader, std::string_view key, const TextLeaf& leaf, Need need) {
  return read_text(reader.faults(), reader.map(), key, leaf.out, need, leaf.most_bytes);
}

bool read(FieldReader& reader, std::string_view key, const MaterialLeaf& leaf, Need need) {
  if (!read_text(reader.faults(), reader.map(), key, leaf.out, need)) return false;
  const MaterialNames& known = reader.materials;
  if (known.set.contains(leaf.out)) return true;
  const Value value = *child(reader.map(), key);
  if (!needs_words(reader.faults(), value.place, value.path)) return false;
  std::string accepted = "expected one that is defined under materials";
  if (!known.list.empty())
    accepted = "expected one of the keys of materials: " + joined(known.list);
  const std::vector<std::string> built_in = known_materials();
  std::vector<std::string_view> all = known.list;
  all.insert(all.end(), built_in.begin(), built_in.end());
  reader.fault(key, fmt::format("no material {}{}; {}, or a built-in one, as `ensonify presets "
                                "materials` prints them",
                                shown(leaf.out), hint(leaf.out, all), accepted));
  return false;
}

bool read(FieldReader& reader, std::string_view key, const FileLeaf& leaf, Need need) {
  std::string name;
  if (!read_text(reader.faults(), reader.map(), key, name, need, kMaxFileNameBytes)) return false;
  const std::filesystem::path found = (reader.input().folder / name).lexically_normal();
  const std::string_view trouble = file_trouble(found, leaf.endings);
  if (!trouble.empty()) {
    reader.fault(key, fmt::format("{} {}; expected a readable file ending in {}", shown(name),
                                  trouble, joined(leaf.endings)));
    return false;
  }
  leaf.out = found;
  return true;
}

bool read(FieldReader& reader, std::string_view key, const WordLeaf& leaf, Need need) {
  const auto index = read_word(reader.faults(), reader.map(), key, as_vector(leaf.words), need);
  if (index) leaf.index = *index;
  return index.has_value();
}

// Branches: return the value that holds the next level of keys.

std::optional<Value> open(FieldReader& reader, std::string_view key, const MapBranch&, Need need) {
  return need == Need::required ? child_or_empty(reader.map(), key) : child(reader.map(), key);
}

std::optional<Value> open(FieldReader& reader, std::string_view key, const ListBranch& branch,
                          Need need) {
  auto value = child(reader.map(), key);
  const ListWords& words = branch.words;
  if (!value && need == Need::required) {
    reader.fault(key, fmt::format("missing; expected {}",
                                  words.missing.empty() ? words.accepted : words.missing));
  }
  if (!value || !open_list(reader.faults(), *value)) return std::nullopt;
  branch.count = value->node->items.size();
  if (branch.count >= words.least && branch.count <= words.most) return value;
  const bool empty = branch.count == 0 && words.least == 1;
  const std::string trouble =
      empty ? "the list is empty" : fmt::format("found a list of length {}", branch.count);
  reader.fault(key, fmt::format("{}; expected {}", trouble, words.accepted));
  return std::nullopt;
}

std::optional<Value> open(FieldReader& reader, std::string_view key, const NamesBranch& branch,
                          Need) {
  auto value = child(reader.map(), key);
  if (!value) return std::nullopt;
  if (value->node->kind != NodeKind::map) {
    reader.fault(key, std::string(branch.what));
    return std::nullopt;
  }
  for (const Key& name : value->node->keys) {
    is_name(reader.faults(), name, path_of(*value, name.text));
    branch.names.push_back(name.text);
  }
  return value;
}

std::optional<Value> open(FieldReader& reader, std::string_view key, const KindBranch& branch,
                          Need) {
  const auto kind = read_kind(reader.faults(), reader.map(), key, as_vector(branch.words));
  if (!kind) return std::nullopt;
  const auto word = std::find(branch.words.begin(), branch.words.end(), kind->word);
  branch.index = static_cast<std::size_t>(word - branch.words.begin());
  return kind->options;
}

std::optional<Value> open(FieldReader& reader, std::string_view key, const SwitchBranch& branch,
                          Need) {
  return read_switch(reader.faults(), reader.map(), key, branch.on);
}

}  // namespace

FieldReader::FieldReader(const InputFolder& input, const Value& map) : input_(input) {
  frames_.push_back({map, true, false, {}, {}});
}

void FieldReader::replace_map(Node tree) {
  replaced_.push_back(std::move(tree));
  frames_.back().value.node = &replaced_.back();
}

void FieldReader::know(std::string_view key) {
  Frame& frame = frames_.back();
  if (!frame.is_map) return;
  if (std::find(frame.known.begin(), frame.known.end(), key) != frame.known.end()) return;
  frame.known.push_back(key);
}

// Marks the key as known and returns whether to read it. Reports a key that has no effect.
bool FieldReader::wants(std::string_view key, const Rule& rule) {
  know(key);
  if (is_mute()) return false;
  if (rule.useless.empty()) return true;
  refuse_useless(faults(), map(), {key}, rule.useless);
  return false;
}

// A key given under its earlier name has been reported already.
Need FieldReader::need_of(std::string_view key, const Rule& rule) const {
  const std::vector<std::string_view>& renamed = frames_.back().renamed;
  const bool is_renamed = std::find(renamed.begin(), renamed.end(), key) != renamed.end();
  return is_renamed ? Need::optional : rule.need;
}

bool FieldReader::leaf(const KeyText& text, const Leaf& leaf, const Rule& rule) {
  const std::string_view key = text.key;
  const auto* numbers = std::get_if<NumbersLeaf>(&leaf);
  if (key.empty() && numbers != nullptr) {
    frames_.back().is_read = true;
    return read_own_numbers(faults(), map(), *numbers);
  }
  if (!wants(key, rule)) return false;
  return std::visit([&](const auto& l) { return read(*this, key, l, need_of(key, rule)); }, leaf);
}

bool FieldReader::begin(const KeyText& text, const Branch& branch, const Rule& rule) {
  const std::string_view key = text.key;
  if (!wants(key, rule)) return false;
  const Need need = need_of(key, rule);
  auto value = std::visit([&](const auto& b) { return open(*this, key, b, need); }, branch);
  const bool has_own_keys =
      std::holds_alternative<ListBranch>(branch) || std::holds_alternative<NamesBranch>(branch);
  if (value) frames_.push_back({std::move(*value), !has_own_keys, false, {}, {}});
  return value.has_value();
}

void FieldReader::end() {
  const Frame frame = std::move(frames_.back());
  frames_.pop_back();
  if (frame.is_map && !frame.is_read) open_map(faults(), frame.value, frame.known);
}

std::optional<std::size_t> FieldReader::only_key(std::span<const std::string_view> keys,
                                                 std::size_t, std::string_view what, Need need) {
  bool any = need == Need::required;
  for (const std::string_view key : keys) {
    know(key);
    any = any || peek(key) != nullptr;
  }
  if (!any || is_mute()) return std::nullopt;
  const auto key = only_key_of(faults(), map(), as_vector(keys), what);
  if (!key) return std::nullopt;
  return static_cast<std::size_t>(std::find(keys.begin(), keys.end(), *key) - keys.begin());
}

void FieldReader::renamed(std::string_view before, std::string_view today) {
  if (peek(before) == nullptr) return;
  know(before);
  frames_.back().renamed.push_back(today);
  fault(before, fmt::format("this key was renamed; expected {}", today));
}

void FieldReader::fault(std::string_view key, std::string text) {
  if (is_mute()) return;
  const auto value = key.empty() ? std::optional(map()) : child(map(), key);
  const Value& at = value ? *value : map();
  add_fault(faults(), at.place, value ? at.path : path_of(map(), key), std::move(text));
}

const Node* FieldReader::peek(std::string_view key) {
  return map().node->kind == NodeKind::map ? find(*map().node, key) : nullptr;
}

std::optional<std::size_t> FieldReader::peek_kind(std::string_view key,
                                                  std::span<const std::string_view> words,
                                                  std::size_t held) {
  const Node* node = peek(key);
  if (node == nullptr) return held;
  const bool is_kind = node->kind == NodeKind::map && node->keys.size() == 1;
  const std::string& word = is_kind ? node->keys[0].text : node->text;
  const auto found = std::find(words.begin(), words.end(), word);
  if (found == words.end()) return std::nullopt;
  return static_cast<std::size_t>(found - words.begin());
}

}  // namespace ensonify
