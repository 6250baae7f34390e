// recording.yaml, which describes a folder of images.
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "recordings/images.h"

namespace ensonify {
namespace {

// Reads the keys of the description and keeps the first fault.
class Keys {
 public:
  explicit Keys(const YAML::Node& map) : map_(map) {}

  template <class T>
  std::optional<T> value(const char* key) {
    known_.insert(key);
    const YAML::Node found = map_[key];
    if (!found) return std::nullopt;
    try {
      return found.as<T>();
    } catch (const YAML::Exception&) {
      refuse(fmt::format("{}: is not a value of the right kind", key));
      return std::nullopt;
    }
  }
  // Whether the second of two words was given.
  bool second(const char* key, const char* first_word, const char* second_word) {
    const auto word = value<std::string>(key).value_or(first_word);
    if (word != first_word && word != second_word) {
      refuse(fmt::format("{}: expected {} or {}", key, first_word, second_word));
    }
    return word == second_word;
  }
  void refuse(const std::string& what) {
    if (fault.empty()) fault = what;
  }
  void refuse_unknown() {
    for (const auto& entry : map_) {
      const auto key = entry.first.as<std::string>("");
      if (!known_.contains(key)) refuse(fmt::format("{}: unknown key", key));
    }
  }

  std::string fault;

 private:
  const YAML::Node& map_;
  std::set<std::string> known_;
};

bool is_between(double value, double low, double high) { return value >= low && value <= high; }

void take_fan(Keys& keys, ImageFolder& folder) {
  folder.azimuth_deg = keys.value<std::vector<double>>("azimuth_deg").value_or(folder.azimuth_deg);
  folder.fan_deg = keys.value<double>("fan_deg").value_or(0);
  const bool fan = folder.fan_deg != 0;
  if (folder.azimuth_deg.empty() != fan) keys.refuse("give one of azimuth_deg and fan_deg");
  if (fan && !is_between(folder.fan_deg, 1e-3, 360)) keys.refuse("fan_deg: expected up to 360");
  for (const double azimuth : folder.azimuth_deg) {
    if (!is_between(azimuth, -180, 180)) keys.refuse("azimuth_deg: expected -180 to 180");
  }
  folder.port_first = !keys.second("columns", "port_first", "starboard_first");
  folder.near_first = !keys.second("rows", "near_first", "far_first");
}

void take_axes(Keys& keys, ImageFolder& folder) {
  const auto range_m = keys.value<std::vector<double>>("range_m").value_or(std::vector<double>{});
  const bool rises = range_m.size() == 2 && is_between(range_m[0], 0, 1e5) &&
                     is_between(range_m[1], range_m[0], 1e5) && range_m[1] > range_m[0];
  if (rises) {
    folder.first_range_m = range_m[0];
    folder.last_range_m = range_m[1];
  } else {
    keys.refuse("range_m: expected the slant ranges of the nearest and the farthest row");
  }
  folder.times_s = keys.value<std::vector<double>>("times_s").value_or(folder.times_s);
  folder.ping_rate_hz = keys.value<double>("ping_rate_hz").value_or(0);
  const bool rate = folder.ping_rate_hz != 0;
  if (folder.times_s.empty() != rate) keys.refuse("give one of ping_rate_hz and times_s");
  if (rate && !is_between(folder.ping_rate_hz, 1e-6, 1e6)) {
    keys.refuse("ping_rate_hz: expected 1e-6 to 1e6");
  }
  for (const double time : folder.times_s) {
    if (!is_between(time, -1e11, 1e11)) keys.refuse("times_s: expected seconds");
  }
}

std::optional<int> count_of(Keys& keys, const char* key, std::uint64_t most) {
  const auto count = keys.value<int>(key);
  if (count && *count >= 2 && std::cmp_less_equal(*count, most)) return count;
  keys.refuse(fmt::format("{}: expected 2 to {}", key, most));
  return std::nullopt;
}

void take_display(Keys& keys, const YAML::Node& map, ImageFolder& folder) {
  keys.value<YAML::Node>("display");
  const YAML::Node display = map["display"];
  if (!display) return;
  if (!display.IsMap()) return keys.refuse("display: expected keys and values");
  for (const char* key : {"columns", "rows"}) {
    if (map[key]) keys.refuse(fmt::format("{}: is of polar images, not of a display", key));
  }
  Keys inner(display);
  FanDisplay fan;
  const auto apex = inner.value<std::vector<double>>("apex_px").value_or(std::vector<double>{});
  if (apex.size() == 2 && is_between(apex[0], -1e6, 1e6) && is_between(apex[1], -1e6, 1e6)) {
    fan.apex_column = apex[0];
    fan.apex_row = apex[1];
  } else {
    inner.refuse("apex_px: expected the column and the row of range 0");
  }
  fan.pixels_per_m = inner.value<double>("pixels_per_m").value_or(0);
  if (!is_between(fan.pixels_per_m, 1e-3, 1e6)) {
    inner.refuse("pixels_per_m: expected 0.001 to 1e6");
  }
  const auto look = inner.value<std::string>("looks").value_or("up");
  constexpr std::array kLooks{"up", "right", "down", "left"};
  const auto found = std::find(kLooks.begin(), kLooks.end(), look);
  if (found == kLooks.end()) inner.refuse("looks: expected up, right, down or left");
  fan.look = static_cast<FanLook>(found - kLooks.begin());
  fan.mirrored = inner.value<bool>("mirrored").value_or(false);
  folder.samples = count_of(inner, "samples", kMostLogSamples).value_or(2);
  folder.beams = static_cast<int>(folder.azimuth_deg.size());
  if (folder.azimuth_deg.empty()) {
    folder.beams = count_of(inner, "beams", kMostLogBeams).value_or(2);
  }
  inner.refuse_unknown();
  if (!inner.fault.empty()) keys.refuse("display." + inner.fault);
  folder.display = fan;
}

void take_scale(Keys& keys, const YAML::Node& map, ImageFolder& folder) {
  keys.value<YAML::Node>("scale");
  const YAML::Node scale = map["scale"];
  if (!scale && folder.display) {
    folder.db = {{0, 255}};
    folder.levels_are_grays = true;
    return;
  }
  if (!scale || !scale.IsMap() || scale.size() != 1) {
    return keys.refuse("scale: expected {db: [LOW, HIGH]} or {gamma: POWER}");
  }
  Keys inner(scale);
  if (scale["db"]) {
    const auto db = inner.value<std::vector<double>>("db").value_or(std::vector<double>{});
    if (db.size() == 2 && is_between(db[0], -1e3, 1e3) && is_between(db[1], db[0] + 1e-3, 1e3)) {
      folder.db = {{db[0], db[1]}};
    } else {
      keys.refuse("scale.db: expected the levels of 0 and of full scale");
    }
    return;
  }
  folder.gamma = inner.value<double>("gamma").value_or(0);
  if (!is_between(folder.gamma, 0.01, 100)) keys.refuse("scale.gamma: expected 0.01 to 100");
}

Result<ImageFolder> folder_from(const YAML::Node& map, const std::string& place) {
  ImageFolder folder;
  Keys keys(map);
  folder.files = keys.value<std::string>("files").value_or("");
  if (folder.files.empty()) keys.refuse("files: expected names of images, such as \"*.png\"");
  take_fan(keys, folder);
  take_axes(keys, folder);
  take_display(keys, map, folder);
  take_scale(keys, map, folder);
  folder.frequency_hz = keys.value<double>("frequency_hz").value_or(0);
  if (!is_between(folder.frequency_hz, 1, 1e9)) keys.refuse("frequency_hz: expected up to 1e9");
  folder.sound_speed_m_s = keys.value<double>("sound_speed_m_s").value_or(1500);
  if (!is_between(folder.sound_speed_m_s, 1000, 2000)) {
    keys.refuse("sound_speed_m_s: expected 1000 to 2000");
  }
  folder.instrument = keys.value<std::string>("instrument").value_or("");
  // Columns of the list from port to starboard fall in azimuth.
  auto& azimuths = folder.azimuth_deg;
  for (std::size_t i = 1; i < azimuths.size(); ++i) {
    if ((azimuths[i - 1] > azimuths[i]) == folder.port_first && azimuths[i - 1] != azimuths[i]) {
      continue;
    }
    keys.refuse(folder.port_first ? "azimuth_deg: expected values that fall, port first"
                                  : "azimuth_deg: expected values that rise, starboard first");
  }
  keys.refuse_unknown();
  if (!keys.fault.empty()) return Error{ErrorKind::usage, place + ": " + keys.fault};
  return folder;
}

}  // namespace

Result<ImageFolder> parse_image_folder(const std::string& text, const std::string& place) {
  try {
    const YAML::Node map = YAML::Load(text);
    if (!map.IsMap()) return Error{ErrorKind::usage, place + ": expected keys and values"};
    return folder_from(map, place);
  } catch (const YAML::Exception& error) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: line {}: {}", place, error.mark.line + 1, error.msg)};
  }
}

}  // namespace ensonify
