// JSON as far as it may be nested. The library's parser goes as deep as the text does; copies and
// dumps of what it made call themselves, and 100 kB of brackets would overflow the stack.
//
//   parse_shallow         discarded where it is no JSON, or nested deeper than kMaxJsonDepth
//   parse_shallow_with    ... with a parser callback of nlohmann::json
#pragma once

#include <nlohmann/json.hpp>
#include <utility>

namespace ensonify {

inline constexpr int kMaxJsonDepth = 64;

// `keep` is a reference that is called for every value.
template <class Json, class Keep, class... Input>
Json parse_shallow_with(Keep& keep, Input&&... input) {
  bool too_deep = false;
  const auto guarded = [&](int depth, typename Json::parse_event_t event, Json& parsed) {
    too_deep = too_deep || depth > kMaxJsonDepth;
    return !too_deep && keep(depth, event, parsed);
  };
  Json json = Json::parse(std::forward<Input>(input)..., guarded, false);
  if (too_deep) json = Json(Json::value_t::discarded);
  return json;
}

template <class Json, class... Input>
Json parse_shallow(Input&&... input) {
  const auto all = [](int, typename Json::parse_event_t, Json&) { return true; };
  return parse_shallow_with<Json>(all, std::forward<Input>(input)...);
}

}  // namespace ensonify
