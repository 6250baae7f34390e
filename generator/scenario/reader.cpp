#include "scenario/reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "scenario/text.h"

namespace ensonify {
namespace {

std::string kind_in_words(const Node& node) {
  switch (node.kind) {
    case NodeKind::null:
      return "nothing";
    case NodeKind::list:
      return "a list";
    case NodeKind::map:
      return "a map";
    case NodeKind::scalar:
      return (node.quoted ? "the quoted text " : "") + shown(node.text);
  }
  return "";
}

void fault(Faults& faults, const Value& value, std::string text) {
  add_fault(faults, value.place, value.path, std::move(text));
}

// Returns the child, or adds an error if it is required and absent. `accepted` builds the text of
// the message only when it is needed, since most values are present.
template <class Words>
std::optional<Value> wanted(Faults& faults, const Value& map, std::string_view key,
                            const Words& accepted, Need need) {
  std::optional<Value> value = child(map, key);
  if (!value && need == Need::required) {
    add_fault(faults, map.place, path_of(map, key),
              fmt::format("missing; expected {}", accepted()));
  }
  return value;
}

// What is wrong with a scalar as a number, whatever its range; empty if nothing is.
std::string number_trouble(const Node& node) {
  if (node.kind != NodeKind::scalar || node.quoted) return kind_in_words(node) + " is not a number";
  const PlainKind kind = classify_plain(node.text);
  if (kind == PlainKind::number) return "";
  const std::string text = shown(node.text);
  switch (kind) {
    case PlainKind::octal_looking:
      return text +
             " looks like an octal number, which YAML readers interpret differently (write it "
             "without the " +
             "leading zero)";
    case PlainKind::other_number:
      if (node.text.find_first_of("nN") != std::string::npos) return text + " is not finite";
      return text + " is not written in plain decimal digits";
    default:
      return text + " is not a number";
  }
}

// from_chars does not accept a leading plus sign.
std::string_view without_plus(std::string_view text) {
  return text.starts_with('+') ? text.substr(1) : text;
}

std::optional<double> number_of(Faults& faults, const Value& value, const NumberRange& range) {
  const auto refuse = [&](const std::string& trouble) {
    fault(faults, value, trouble + "; expected " + in_words(range, "number"));
    return std::nullopt;
  };
  const std::string trouble = number_trouble(*value.node);
  if (!trouble.empty()) return refuse(trouble);
  const std::string_view digits = without_plus(value.node->text);
  double number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error == std::errc::result_out_of_range) {
    return refuse(shown(value.node->text) + " is too large or too small for a double");
  }
  if (error != std::errc{} || end != digits.data() + digits.size()) {
    return refuse(shown(value.node->text) + " is not a number");
  }
  if (number < range.low || number > range.high || (range.low_excluded && number == range.low)) {
    return refuse(shown(value.node->text) + " is out of range");
  }
  return number + 0.0;  // -0 becomes 0, so that equal scenarios read the same
}

bool only_digits(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

// What is wrong with a scalar as text; empty if nothing is.
std::string text_trouble(std::string_view text, bool quoted, std::size_t max_bytes) {
  if (text.empty()) return "empty";
  if (text.size() > max_bytes)
    return fmt::format("{} is longer than {} bytes", shown(text), max_bytes);
  if (first_control_character(text, "")) return shown(text) + " contains a control character";
  if (quoted) return "";
  switch (classify_plain(text)) {
    case PlainKind::text:
      return "";
    case PlainKind::octal_looking:
      return shown(text) + " looks like an octal number unless it is quoted";
    case PlainKind::number:
    case PlainKind::other_number:
      return shown(text) + " is a number unless it is quoted";
    case PlainKind::boolean:
    case PlainKind::switch_word:
      return shown(text) + " is a boolean to some YAML readers unless it is quoted";
  }
  return "";
}

std::string text_in_words(std::size_t max_bytes) {
  return fmt::format("printable text of 1 to {} bytes", max_bytes);
}

void refuse_unknown_key(Faults& faults, const Value& map, const Key& key,
                        const std::vector<std::string_view>& known) {
  const std::string path = path_of(map, key.text);
  if (!needs_words(faults, key.place, path)) return;
  const std::string accepted =
      known.empty() ? "this map has no keys"
                    : "expected " + std::string(known.size() == 1 ? "" : "one of ") + joined(known);
  std::string text = fmt::format("unknown key{}; {}", hint(key.text, known), accepted);
  add_fault(faults, key.place, path, std::move(text));
}

std::string numbers_in_words(std::size_t count) {
  return fmt::format("a list of {} numbers", count);
}

std::string integer_in_words(int low, int high) {
  return low == high ? std::to_string(low) : fmt::format("an integer from {} to {}", low, high);
}

}  // namespace

void wrong_kind(Faults& faults, const Value& value, std::string_view accepted) {
  fault(faults, value, fmt::format("found {}; expected {}", kind_in_words(*value.node), accepted));
}

// Every value that is read has its path built; fmt would take a third of the time of reading.
std::string joined_path(std::string_view map, std::string_view key) {
  std::string path;
  path.reserve(map.size() + 1 + key.size());
  path += map;
  if (!map.empty()) path += '.';
  path += key;
  return path;
}

std::string path_of(const Value& map, std::string_view key) { return joined_path(map.path, key); }

std::optional<Value> child(const Value& map, std::string_view key) {
  if (map.node->kind == NodeKind::list) {
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
    const bool is_index = error == std::errc{} && end == key.data() + key.size();
    if (!is_index || index >= map.node->items.size()) return std::nullopt;
    return item(map, index);
  }
  const Node* node = find(*map.node, key);
  if (node == nullptr) return std::nullopt;
  return Value{node, node->place, path_of(map, key)};
}

std::optional<Place> place_in(const Node& tree, std::string_view path) {
  Value deepest{&tree, tree.place, ""};
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    auto next = child(deepest, path.substr(begin, end - begin));
    if (!next) break;
    deepest = std::move(*next);
    begin = end + 1;
  }
  return deepest.node == &tree ? std::nullopt : std::optional(deepest.place);
}

Value child_or_empty(const Value& map, std::string_view key) {
  static const Node empty = [] {
    Node node;
    node.kind = NodeKind::map;
    return node;
  }();
  if (std::optional<Value> value = child(map, key)) return *value;
  return {&empty, map.place, path_of(map, key)};
}

Value item(const Value& list, std::size_t index) {
  const Node& node = list.node->items[index];
  return {&node, node.place, path_of(list, std::to_string(index))};
}

bool open_map(Faults& faults, const Value& value, const std::vector<std::string_view>& known) {
  if (value.node->kind != NodeKind::map) {
    wrong_kind(faults, value, known.empty() ? "an empty map {}" : "a map with " + joined(known));
    return false;
  }
  for (const Key& key : value.node->keys) {
    bool is_known = false;
    for (const std::string_view word : known) is_known = is_known || word == key.text;
    if (!is_known) refuse_unknown_key(faults, value, key, known);
  }
  return true;
}

bool open_list(Faults& faults, const Value& value) {
  if (value.node->kind == NodeKind::list) return true;
  wrong_kind(faults, value, "a list");
  return false;
}

std::optional<std::string_view> only_key_of(Faults& faults, const Value& map,
                                            const std::vector<std::string_view>& keys,
                                            std::string_view what) {
  std::vector<std::string_view> present;
  Place second = map.place;
  for (std::size_t i = 0; i < map.node->keys.size(); ++i) {
    for (const std::string_view key : keys) {
      if (map.node->keys[i].text != key) continue;
      present.push_back(key);
      if (present.size() == 2) second = map.node->keys[i].place;
    }
  }
  if (present.size() == 1) return present.front();
  add_fault(faults, second, map.path,
            present.empty()
                ? fmt::format("missing; expected {}", what)
                : fmt::format("{} exclude each other; expected {}", joined(present), what));
  return std::nullopt;
}

std::string in_words(const NumberRange& range, std::string_view noun) {
  if (range.low_excluded)
    return fmt::format("a {} > {:g}, at most {:g}", noun, range.low, range.high);
  return fmt::format("a {} from {:g} to {:g}", noun, range.low, range.high);
}

bool read_number(Faults& faults, const Value& map, std::string_view key, const NumberRange& range,
                 double& out, Need need) {
  const auto value = wanted(
      faults, map, key, [&] { return in_words(range, "number"); }, need);
  if (!value) return false;
  const std::optional<double> number = number_of(faults, *value, range);
  if (number) out = *number;
  return number.has_value();
}

bool read_numbers(Faults& faults, const Value& map, std::string_view key, const NumberRange& range,
                  double* out, std::size_t count, Need need) {
  const auto value = wanted(
      faults, map, key, [&] { return numbers_in_words(count); }, need);
  return value && read_numbers_of(faults, *value, range, out, count);
}

bool read_numbers_of(Faults& faults, const Value& value, const NumberRange& range, double* out,
                     std::size_t count) {
  if (value.node->kind != NodeKind::list) {
    wrong_kind(faults, value, numbers_in_words(count));
    return false;
  }
  if (value.node->items.size() != count) {
    fault(faults, value,
          fmt::format("found a list of length {}; expected {}", value.node->items.size(),
                      numbers_in_words(count)));
    return false;
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) {
    if (const auto number = number_of(faults, item(value, i), range)) numbers.push_back(*number);
  }
  if (numbers.size() != count) return false;
  std::copy(numbers.begin(), numbers.end(), out);
  return true;
}

bool read_integer(Faults& faults, const Value& map, std::string_view key, int low, int high,
                  int& out, Need need) {
  const auto value = wanted(
      faults, map, key, [&] { return integer_in_words(low, high); }, need);
  if (!value) return false;
  std::string trouble = number_trouble(*value->node);
  if (trouble.empty()) {
    const std::string_view text = without_plus(value->node->text);
    const std::string_view digits = text.starts_with('-') ? text.substr(1) : text;
    int number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (!only_digits(digits)) {
      trouble = shown(value->node->text) + " is not an integer";
    } else if (error != std::errc{} || number < low || number > high) {
      trouble = shown(value->node->text) + " is out of range";
    } else {
      out = number;
      return true;
    }
  }
  fault(faults, *value, trouble + "; expected " + integer_in_words(low, high));
  return false;
}

void refuse_useless(Faults& faults, const Value& map, const std::vector<std::string_view>& keys,
                    std::string_view why) {
  for (const std::string_view key : keys) {
    const auto useless = child(map, key);
    if (!useless) continue;
    add_fault(faults, useless->place, useless->path, fmt::format("has no effect {}", why));
  }
}

bool read_seed(Faults& faults, const Value& map, std::string_view key, std::uint64_t& out) {
  const auto value = child(map, key);
  if (!value) return false;
  std::string trouble = number_trouble(*value->node);
  if (trouble.empty()) {
    const std::string_view digits = without_plus(value->node->text);
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (only_digits(digits) && error == std::errc{}) {
      out = number;
      return true;
    }
    trouble = shown(value->node->text) + " is not an unsigned 64-bit integer";
  }
  fault(faults, *value,
        fmt::format("{}; expected an integer from 0 to {}", trouble,
                    std::numeric_limits<std::uint64_t>::max()));
  return false;
}

bool read_boolean(Faults& faults, const Value& map, std::string_view key, bool& out) {
  const auto value = child(map, key);
  if (!value) return false;
  const Node& node = *value->node;
  if (node.kind == NodeKind::scalar && !node.quoted &&
      (node.text == "true" || node.text == "false")) {
    out = node.text == "true";
    return true;
  }
  wrong_kind(faults, *value, "true or false");
  return false;
}

std::optional<std::size_t> read_word(Faults& faults, const Value& map, std::string_view key,
                                     const std::vector<std::string_view>& words, Need need) {
  const auto accepted = [&] { return (words.size() == 1 ? "" : "one of ") + joined(words); };
  const auto value = wanted(faults, map, key, accepted, need);
  if (!value) return std::nullopt;
  const Node& node = *value->node;
  if (node.kind != NodeKind::scalar) {
    wrong_kind(faults, *value, accepted());
    return std::nullopt;
  }
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == node.text) return i;
  }
  fault(faults, *value,
        fmt::format("{} is not known{}; expected {}", shown(node.text), hint(node.text, words),
                    accepted()));
  return std::nullopt;
}

bool read_text(Faults& faults, const Value& map, std::string_view key, std::string& out, Need need,
               std::size_t max_bytes) {
  const auto accepted = [&] { return text_in_words(max_bytes); };
  const auto value = wanted(faults, map, key, accepted, need);
  if (!value) return false;
  if (value->node->kind != NodeKind::scalar) {
    wrong_kind(faults, *value, accepted());
    return false;
  }
  const std::string trouble = text_trouble(value->node->text, value->node->quoted, max_bytes);
  if (trouble.empty()) {
    out = value->node->text;
    return true;
  }
  fault(faults, *value, trouble + "; expected " + accepted());
  return false;
}

bool is_name(Faults& faults, const Key& key, const std::string& path) {
  const std::string trouble = text_trouble(key.text, key.quoted, kMaxNameBytes);
  if (trouble.empty()) return true;
  add_fault(faults, key.place, path, trouble + "; expected " + text_in_words(kMaxNameBytes));
  return false;
}

}  // namespace ensonify
