#include "scenario/distribution.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>

#include <fmt/format.h>

namespace ensonify {

bool is_head_key(std::string_view key) {
  return key == "ensonify" || key == "seed" || key == "speckle_seed" || key == "sequences";
}

bool is_distribution(const Node& node) {
  if (node.kind != NodeKind::map || node.keys.size() != 1) return false;
  if (node.items[0].kind != NodeKind::list) return false;
  const std::string& key = node.keys[0].text;
  return key == "uniform" || key == "log_uniform" || key == "normal" || key == "choice";
}

bool holds_distribution(const Node& node) {
  return is_distribution(node) ||
         std::any_of(node.items.begin(), node.items.end(), holds_distribution);
}

bool has_counts(std::string_view section, const Node& node) {
  return is_counted_list(section) && node.kind == NodeKind::list &&
         std::any_of(node.items.begin(), node.items.end(), [](const Node& entry) {
           return entry.kind == NodeKind::map && find(entry, "count") != nullptr;
         });
}

bool is_counted_list(std::string_view path) { return path == "objects" || path == "point_targets"; }

std::size_t variants_of_choice(const Node& alternatives) {
  std::size_t sum = 0;
  for (const Node& alternative : alternatives.items) sum += draw_variants(alternative);
  return std::max<std::size_t>(sum, 1);
}

std::size_t draw_variants(const Node& node) {
  if (is_distribution(node) && node.keys[0].text == "choice") {
    return variants_of_choice(node.items[0]);
  }
  std::size_t most = 1;
  for (const Node& item : node.items) most = std::max(most, draw_variants(item));
  return most;
}

std::string distribution_trouble(std::string_view kind, const std::array<double, 2>& given) {
  const auto [a, b] = given;
  if (kind == "normal") {
    if (b >= 0) return "";
    return fmt::format("the standard deviation is {}; expected [mean, sd] with sd >= 0", b);
  }
  if (kind == "log_uniform" && (a <= 0 || b <= 0)) {
    return fmt::format(
        "the limits {} and {} do not both have a logarithm; expected [a, b] with 0 < a <= b", a, b);
  }
  if (a <= b) return "";
  return fmt::format("{} is above {}; expected [a, b] with a <= b", a, b);
}

std::optional<std::int64_t> whole_number(const Node& node) {
  constexpr std::int64_t kMaxWhole = std::int64_t{1} << 53;
  std::string_view text = node.text;
  if (node.kind != NodeKind::scalar || node.quoted) return std::nullopt;
  if (text.starts_with('+')) text.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc{} && end == text.data() + text.size();
  if (!whole || std::abs(value) > kMaxWhole) return std::nullopt;
  return value;
}

std::string without_choices(std::string path) {
  constexpr std::string_view kMark = ".choice.";
  for (auto at = path.find(kMark); at != std::string::npos; at = path.find(kMark, at)) {
    const auto number = at + kMark.size();
    const auto end = std::min(path.find_first_not_of("0123456789", number), path.size());
    path.erase(at, end - at);
  }
  return path;
}

}  // namespace ensonify
