#include "fit/key_text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace ensonify {
namespace {

std::optional<double> number_in(std::string_view text) {
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = read.ec == std::errc() && read.ptr == text.data() + text.size();
  return whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

Error refused(const std::string& text, const char* why) {
  return {ErrorKind::usage,
          fmt::format("--key {}: {}; expected PATH=LOW:HIGH or PATH=LOW:HIGH:log, such as "
                      "sonar.beams.receive_width_deg=0.5:2",
                      text, why)};
}

}  // namespace

Result<FitKey> parse_key(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) return refused(text, "there is no path with =");
  std::string_view range = std::string_view(text).substr(equals + 1);
  FitKey key;
  key.path = text.substr(0, equals);
  if (range.ends_with(":log")) {
    key.log = true;
    range.remove_suffix(4);
  }
  const std::size_t colon = range.find(':');
  if (colon == std::string_view::npos) return refused(text, "the range has no colon");
  const auto low = number_in(range.substr(0, colon)), high = number_in(range.substr(colon + 1));
  if (!low || !high) return refused(text, "a bound is not a number");
  if (!(*low < *high)) return refused(text, "the first bound is not below the second");
  if (key.log && !(*low > 0)) return refused(text, "a logarithmic range must be above 0");
  key.low = *low;
  key.high = *high;
  return key;
}

std::string key_text(double value) { return fmt::format("{}", value); }

}  // namespace ensonify
