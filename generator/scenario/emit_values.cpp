#include <fmt/format.h>

#include "scenario/emit.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

std::string rotation(const RotationSpec& spec) {
  if (const auto* angles = std::get_if<std::array<double, 3>>(&spec)) {
    return "rotation_deg: " + numbers(*angles);
  }
  const Quat& q = std::get<Quat>(spec);
  return "quaternion_wxyz: " + numbers(std::array<double, 4>{q.w, q.x, q.y, q.z});
}

}  // namespace

std::string number(double value) {
  std::string text = fmt::format("{}", value);
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) {
    text.insert(exponent, ".0");
  }
  return text;
}

std::string quoted_if_needed(const std::string& text) {
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
  constexpr std::string_view kOthers = "0123456789.-/";
  const auto one_of = [](char c, std::string_view set) {
    return set.find(c) != std::string_view::npos;
  };
  bool plain = !text.empty() && one_of(text[0], kLetters);
  for (const char c : text) plain = plain && (one_of(c, kLetters) || one_of(c, kOthers));
  for (const char* word : {"null", "y", "n"}) plain = plain && !equals_ignoring_case(text, word);
  if (plain && classify_plain(text) == PlainKind::text) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::string pose_keys(const PoseSpec& pose) {
  return fmt::format("position_m: {}, {}", numbers(pose.position_m), rotation(pose.rotation));
}

std::string place_keys(const PlaceSpec& place) {
  return fmt::format(
      "on: {}, area_m: [{}, {}], clearance_m: {}, sink_m: {}, yaw: {}, align: {}, {}",
      quoted_if_needed(place.on), numbers(place.area_m[0]), numbers(place.area_m[1]),
      number(place.clearance_m), number(place.sink_m), place.any_yaw ? "any" : "fixed",
      place.along_surface ? "surface" : "up", rotation(place.rotation));
}

}  // namespace ensonify
