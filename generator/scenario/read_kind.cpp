#include <algorithm>

#include <fmt/format.h>

#include "scenario/reader.h"
#include "scenario/text.h"

namespace ensonify {

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
  // A mistyped kind has its fault already.
  if (!any && !value->node->keys.empty()) return std::nullopt;
  const auto word = only_key_of(faults, *value, words, "one of " + joined(words));
  if (!word) return std::nullopt;
  return Kind{*word, *child(*value, *word)};
}

void refuse_useless(Faults& faults, const Value& map, const std::vector<std::string_view>& keys,
                    std::string_view why) {
  for (const std::string_view key : keys) {
    const auto useless = child(map, key);
    if (!useless) continue;
    add_fault(faults, useless->place, useless->path, fmt::format("of no effect {}", why));
  }
}

}  // namespace ensonify
