// The keys of a scenario, declared once. A function `fields` for each struct names every key with
// its variable, its range and its rule, in the order of the resolved text. FieldReader fills the
// struct from a tree and reports errors; FieldWriter writes the resolved text.
//
//   KindText                                  the meaning of a word, for the schema and the docs
//   Leaf  Branch                              a single value; a container of values
//   Fields                                    the values, maps and lists of a struct by their keys
//   fields                                    of every struct, in the file of its section
//
// A function of Fields for a single value returns whether the value was read, and false when
// writing. A function that begins a branch returns whether the caller must request the keys of the
// branch, up to end().
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/keys.h"
#include "scenario/reader.h"
#include "scenario/text.h"

namespace ensonify {

class FieldReader;

// The title and meaning of a word of a kind.
struct KindText {
  std::string_view title, meaning;
};

// Used if the length is not from `least` to `most`: "the list is empty" or "found a list of length
// N".
struct ListWords {
  std::string_view missing;   // what is expected if the list is missing but required
  std::string_view accepted;  // also used in place of an empty `missing`
  std::size_t least = 0;
  std::size_t most = std::numeric_limits<std::size_t>::max();
};

// A single value: its variable and its valid values.
struct NumberLeaf {
  double& out;
  const NumberRange& range;
};
struct NumbersLeaf {
  std::span<double> out;
  const NumberRange& range;
};
struct IntegerLeaf {
  int& out;
  int low, high;
};
struct SeedLeaf {
  std::uint64_t& out;
};
struct BooleanLeaf {
  bool& out;
};
struct TextLeaf {
  std::string& out;
  std::size_t most_bytes;
};
struct MaterialLeaf {
  std::string& out;  // the name of a material
};
struct FileLeaf {
  std::filesystem::path& out;
  std::initializer_list<std::string_view> endings;
};
struct WordLeaf {
  std::span<const std::string_view> words;
  std::size_t& index;
};
using Leaf = std::variant<NumberLeaf, NumbersLeaf, IntegerLeaf, SeedLeaf, BooleanLeaf, TextLeaf,
                          MaterialLeaf, FileLeaf, WordLeaf>;

// A container of values. Items of lists have their indexes as keys.
struct MapBranch {};
struct ListBranch {
  std::size_t& count;  // number of items read, or to be written
  const ListWords& words;
};
struct NamesBranch {                // a map whose keys are names
  std::vector<std::string>& names;  // names read, or to be written
  std::string_view what;            // error if the value is not a map
};
struct KindBranch {  // one of the words, or a map of it with its options, which are entered
  std::span<const std::string_view> words;
  std::size_t& index;
  std::span<const KindText> texts;  // of the words
};
struct SwitchBranch {  // true, false, or a map of options, which are entered
  bool& on;
};
using Branch = std::variant<MapBranch, ListBranch, NamesBranch, KindBranch, SwitchBranch>;

class Fields {
 public:
  Fields() = default;
  Fields(const Fields&) = delete;
  Fields& operator=(const Fields&) = delete;
  virtual ~Fields() = default;

  virtual bool writing() const = 0;
  // The reader of an existing map; null when writing or if there is nothing to read.
  virtual FieldReader* reader() { return nullptr; }

  // Numbers without a key are the value itself, inside a kind.
  virtual bool leaf(const KeyText& key, const Leaf& leaf, const Rule& rule) = 0;
  virtual bool begin(const KeyText& key, const Branch& branch, const Rule& rule) = 0;
  virtual void end() = 0;

  // Returns which of these mutually exclusive keys the map has; `held` when writing. Empty if the
  // map has several of them, or none, which is an error if one is required; `what` describes the
  // expected keys.
  virtual std::optional<std::size_t> only_key(std::span<const std::string_view> keys,
                                              std::size_t held, std::string_view what,
                                              Need need = Need::required) = 0;

  // Reports a key of this map that is given under its earlier name, with its current name.
  virtual void renamed(std::string_view, std::string_view) {}
  // Describes an integer that is read before the fields.
  virtual void describe_count(const KeyText&, int, int) {}

  // Adds an error at a key, or at the map itself if the key is empty.
  virtual void fault(std::string_view, std::string) {}
  // The map's value of a key that another value depends on; null if absent or when writing.
  virtual const Node* peek(std::string_view) { return nullptr; }
  // The one of `words` that the value of a key names: `held` if it is absent or when writing, empty
  // if it is something else.
  virtual std::optional<std::size_t> peek_kind(std::string_view, std::span<const std::string_view>,
                                               std::size_t held) {
    return held;
  }

  bool number(const KeyText& key, double& out, const NumberRange& range, Rule rule = {}) {
    return leaf(key, NumberLeaf{out, range}, rule);
  }
  bool numbers(const KeyText& key, std::span<double> out, const NumberRange& range,
               Rule rule = {}) {
    return leaf(key, NumbersLeaf{out, range}, rule);
  }
  bool integer(const KeyText& key, int& out, int low, int high, Rule rule = {}) {
    return leaf(key, IntegerLeaf{out, low, high}, rule);
  }
  bool seed(const KeyText& key, std::uint64_t& out) { return leaf(key, SeedLeaf{out}, {}); }
  bool boolean(const KeyText& key, bool& out, Rule rule = {}) {
    return leaf(key, BooleanLeaf{out}, rule);
  }
  // A name.
  bool text(const KeyText& key, std::string& out, Rule rule = {}) {
    return leaf(key, TextLeaf{out, kMaxNameBytes}, rule);
  }
  bool long_text(const KeyText& key, std::string& out, std::size_t most_bytes, Rule rule = {}) {
    return leaf(key, TextLeaf{out, most_bytes}, rule);
  }
  bool material(const KeyText& key, std::string& out) {
    return leaf(key, MaterialLeaf{out}, kRequired);
  }
  bool file(const KeyText& key, std::filesystem::path& out,
            std::initializer_list<std::string_view> endings, Rule rule = {}) {
    return leaf(key, FileLeaf{out, endings}, rule);
  }
  bool word(const KeyText& key, std::span<const std::string_view> words, std::size_t& index,
            Rule rule = {}) {
    return leaf(key, WordLeaf{words, index}, rule);
  }
  bool begin(const KeyText& key, Rule rule = {}) { return begin(key, MapBranch{}, rule); }
  bool begin_kind(const KeyText& key, std::span<const std::string_view> words,
                  std::span<const KindText> texts, std::size_t& index, Rule rule = {}) {
    return begin(key, KindBranch{words, index, texts}, rule);
  }
  bool begin_switch(const KeyText& key, bool& on, Rule rule = {}) {
    return begin(key, SwitchBranch{on}, rule);
  }

  // Values that may be absent.
  bool number(const KeyText& key, std::optional<double>& out, const NumberRange& range,
              Rule rule = {}) {
    double value = out.value_or(0);
    rule.has_default = out.has_value();
    const bool read = number(key, value, range, written_if(rule.written && out, rule));
    if (read) out = value;
    return read;
  }
  bool seed(const KeyText& key, std::optional<std::uint64_t>& out) {
    std::uint64_t value = out.value_or(0);
    const bool read =
        leaf(key, SeedLeaf{value}, written_if(out.has_value(), {.has_default = false}));
    if (read) out = value;
    return read;
  }
  bool integer(const KeyText& key, std::optional<int>& out, int low, int high, Rule rule = {}) {
    int value = out.value_or(0);
    rule.has_default = out.has_value();
    const bool read = integer(key, value, low, high, written_if(rule.written && out, rule));
    if (read) out = value;
    return read;
  }
  template <std::size_t N>
  bool numbers(const KeyText& key, std::optional<std::array<double, N>>& out,
               const NumberRange& range, Rule rule = {}) {
    std::array<double, N> values = out.value_or(std::array<double, N>{});
    rule.has_default = out.has_value();
    const bool read = numbers(key, values, range, written_if(rule.written && out, rule));
    if (read) out = values;
    return read;
  }

  // A number, or a list of at most `most`.
  bool number(const KeyText& key, OneOrMore& out, const NumberRange& range, Rule rule = {},
              std::size_t most = 32) {
    const Node* given = peek(key.key);
    const bool is_list =
        writing() ? out.values.size() > 1 : given != nullptr && given->kind == NodeKind::list;
    rule.has_default = !out.values.empty();
    rule.written = rule.written && !out.values.empty();
    if (is_list) {
      const std::string accepted = "a number, or 1 to " + std::to_string(most) + " numbers";
      return list(
          key, out.values, {"", accepted, 1, most}, rule,
          [&](const std::string& at, double& value) { number(at, value, range, kRequired); });
    }
    double value = out.values.empty() ? 0 : out.values[0];
    const bool read = number(key, value, range, rule);
    if (read) out.values = {value};
    return read;
  }

  // A switch without options.
  void toggle(const KeyText& key, bool& on, Rule rule = {}) {
    if (begin_switch(key, on, rule)) end();
  }

  template <class T>
  bool choice(const KeyText& key, T& out, std::span<const std::pair<std::string_view, T>> choices,
              Rule rule = {}) {
    std::vector<std::string_view> words;
    std::size_t index = 0;
    for (const auto& [choice_word, value] : choices) {
      if (value == out) index = words.size();
      words.push_back(choice_word);
    }
    const bool read = word(key, words, index, rule);
    if (read) out = choices[index].second;
    return read;
  }
  template <class T>
  bool choice(const KeyText& key, T& out,
              std::initializer_list<std::pair<std::string_view, T>> choices, Rule rule = {}) {
    return choice(key, out, std::span(choices.begin(), choices.size()), rule);
  }

  // The same as peek_kind for an enumeration from 0 to `last`.
  template <class T>
  std::optional<T> peek_kind(std::string_view key, T held, T last) {
    std::vector<std::string_view> words;
    for (const auto& kind : words_to(last)) words.push_back(kind.first);
    const auto index = peek_kind(key, words, static_cast<std::size_t>(held));
    return index ? std::optional(static_cast<T>(*index)) : std::nullopt;
  }

  // A kind that is an enumeration from 0 to `last`, spelled by name_of.
  template <class T>
  bool begin_kind(const KeyText& key, T& out, T last, std::span<const KindText> texts,
                  Rule rule = {}) {
    std::vector<std::string_view> words;
    for (const auto& kind : words_to(last)) words.push_back(kind.first);
    auto index = static_cast<std::size_t>(out);
    const bool entered = begin_kind(key, words, texts, index, rule);
    if (entered) out = static_cast<T>(index);
    return entered;
  }

  // A map of one struct.
  template <class T>
  bool map(const KeyText& key, T& value, Rule rule = {}) {
    if (!begin(key, rule)) return false;
    fields(*this, value);
    end();
    return true;
  }
  template <class T>
  void map(const KeyText& key, std::optional<T>& value, Rule rule = {}) {
    rule.has_default = value.has_value();
    if (!begin(key, written_if(rule.written && value, rule))) return;
    if (!value) value.emplace();
    fields(*this, *value);
    end();
  }

  // The same for a struct whose keys `each(io, value)` lists (core/keys.h).
  template <class T, class Each>
  void part(const KeyText& key, std::optional<T>& value, Each each, Rule rule = {}) {
    rule.has_default = value.has_value();
    rule.written = rule.written && value.has_value();
    if (!begin(key, rule)) return;
    T values = value.value_or(T{});
    each(*this, values);
    value = values;
    end();
  }

  // Exactly one kind of thing, as a map under the key of the kind.
  template <class... Kinds>
  std::optional<std::size_t> one_of(std::variant<Kinds...>& value,
                                    const std::array<KeyText, sizeof...(Kinds)>& kinds) {
    std::vector<std::string_view> keys;
    for (const KeyText& kind : kinds) keys.push_back(kind.key);
    const auto index = only_key(keys, value.index(), "one of " + joined(keys));
    if (index) map_kind(value, *index, kinds[*index], std::index_sequence_for<Kinds...>{});
    return index;
  }

  // A list; `each(key, item)` reads or writes an item.
  template <class T, class Each>
  bool list(const KeyText& key, std::vector<T>& items, const ListWords& words, Rule rule,
            Each each) {
    std::size_t count = items.size();
    if (!begin(key, ListBranch{count, words}, rule)) return false;
    if (!writing()) items.assign(count, T{});
    for (std::size_t i = 0; i < count; ++i) each(std::to_string(i), items[i]);
    end();
    return true;
  }
  template <class T>
  void maps(const KeyText& key, std::vector<T>& items, Rule rule = {},
            const ListWords& words = {}) {
    list(key, items, words, rule, [this](const std::string& at, T& item) { map(at, item); });
  }

 private:
  template <class Variant, std::size_t... I>
  void map_kind(Variant& value, std::size_t index, const KeyText& key, std::index_sequence<I...>) {
    const auto enter = [&]<std::size_t i>() {
      if (i != index) return;
      if (!writing()) value.template emplace<i>();
      map(key, std::get<i>(value));
    };
    (enter.template operator()<I>(), ...);
  }
};

// The words of an enumeration from 0 to `last`, spelled by name_of.
template <class T>
std::vector<std::pair<std::string_view, T>> words_to(T last) {
  std::vector<std::pair<std::string_view, T>> words;
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    words.emplace_back(name_of(static_cast<T>(i)), static_cast<T>(i));
  }
  return words;
}

}  // namespace ensonify
