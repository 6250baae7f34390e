#include "recordings/neusis.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "core/counted.h"
#include "core/units.h"
#include "formats/bytes.h"
#include "formats/files.h"
#include "formats/json.h"
#include "formats/natural_order.h"
#include "recordings/pickle.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

constexpr char kConfig[] = "Config.json", kData[] = "Data", kPickleEnd[] = ".pkl";
constexpr char kSonarKey[] = "ImagingSonar", kPoseKey[] = "PoseSensor";
constexpr std::uint64_t kMostPickleBytes = std::uint64_t{1} << 28;
constexpr double kFullScale = 65'535;
constexpr double kAssumedFrequency_hz = 1e6, kAssumedRate_hz = 1;

// The first sonar, or, if there is none, the last sensor that has a range: the loader of SonarSplat
// takes the last sensor, whatever its type.
const Json* sensor_of(const Json& config) {
  const Json* agents = member(config, "agents");
  if (agents == nullptr || !agents->is_array()) return nullptr;
  const Json* last = nullptr;
  for (const Json& agent : *agents) {
    const Json* sensors = member(agent, "sensors");
    if (sensors == nullptr || !sensors->is_array()) continue;
    for (const Json& sensor : *sensors) {
      if (text_at(sensor, "sensor_type") == kSonarKey) return &sensor;
      const Json* configuration = member(sensor, "configuration");
      if (configuration != nullptr && number_at(*configuration, "RangeMax")) last = &sensor;
    }
  }
  return last;
}

// The rotation of a matrix whose columns are unit vectors at right angles; none if they are not.
std::optional<Quat> rotation_of(const std::vector<double>& m) {
  const auto at = [&](std::size_t row, std::size_t column) { return m[4 * row + column]; };
  constexpr double kTolerance = 1e-3;  // far above the rounding of 32-bit floats
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      const double product = at(0, a) * at(0, b) + at(1, a) * at(1, b) + at(2, a) * at(2, b);
      if (!(std::abs(product - (a == b ? 1 : 0)) < kTolerance)) return std::nullopt;
    }
  }
  const double handedness = at(0, 0) * (at(1, 1) * at(2, 2) - at(2, 1) * at(1, 2)) -
                            at(0, 1) * (at(1, 0) * at(2, 2) - at(2, 0) * at(1, 2)) +
                            at(0, 2) * (at(1, 0) * at(2, 1) - at(2, 0) * at(1, 1));
  if (handedness < 0) return std::nullopt;
  const double x = at(0, 0), y = at(1, 1), z = at(2, 2);
  // Four times each squared component (Shepperd 1978); the largest one is the safe divisor.
  const std::array<double, 4> squares{1 + x + y + z, 1 + x - y - z, 1 - x + y - z, 1 - x - y + z};
  const double wx = at(2, 1) - at(1, 2), wy = at(0, 2) - at(2, 0), wz = at(1, 0) - at(0, 1);
  const double xy = at(1, 0) + at(0, 1), xz = at(2, 0) + at(0, 2), yz = at(2, 1) + at(1, 2);
  switch (std::max_element(squares.begin(), squares.end()) - squares.begin()) {
    case 0:
      return normalized({squares[0], wx, wy, wz});
    case 1:
      return normalized({wx, squares[1], xy, xz});
    case 2:
      return normalized({wy, xy, squares[2], yz});
    default:
      return normalized({wz, xz, yz, squares[3]});
  }
}

// What is wrong with it; empty: nothing.
std::string take_pickled_pose(const UnpickledArray& array, LogFrame& frame) {
  if (array.shape != std::vector<std::uint64_t>{4, 4}) {
    return fmt::format("{}: expected a matrix of 4 x 4", kPoseKey);
  }
  const std::vector<double> m = values_of(array);
  const auto rotation = rotation_of(m);
  const Vec3 position{m[3], m[7], m[11]};
  const auto is_near = [](double value) { return std::abs(value) < 1e9; };
  if (!rotation || !is_near(position.x) || !is_near(position.y) || !is_near(position.z)) {
    return fmt::format("{}: is not a rotation and a position", kPoseKey);
  }
  frame.sonar_in_world = {position, *rotation};
  return {};
}

std::string take_pickled_axes(const NeusisConfig& config, const UnpickledArray& image,
                              LogSettings& settings) {
  if (image.shape.size() != 2 || (image.dtype != "f4" && image.dtype != "f8")) {
    return fmt::format("{}: expected floats [ranges, azimuths]", kSonarKey);
  }
  const std::uint64_t samples = config.range_bins.value_or(image.shape[0]);
  const std::uint64_t beams = config.azimuth_bins.value_or(image.shape[1]);
  if (samples > image.shape[0] || beams > image.shape[1]) {
    return fmt::format("{}: {} ranges and {} azimuths; {} has {} and {}", kSonarKey, image.shape[0],
                       image.shape[1], kConfig, samples, beams);
  }
  if (samples < 2 || beams < 2 || samples > kMostLogSamples || beams > kMostLogBeams) {
    return fmt::format("{}: {} x {} pixels; expected at least 2 x 2", kSonarKey, samples, beams);
  }
  settings.samples = static_cast<int>(samples);
  settings.beams = static_cast<int>(beams);
  settings.bits = 16;
  settings.sound_speed_m_s = 1500;
  settings.range_step_m = (config.range_max_m - config.range_min_m) / static_cast<double>(samples);
  settings.first_range_m = config.range_min_m + settings.range_step_m / 2;
  for (std::uint64_t j = 0; j < beams; ++j) {
    const double part = (static_cast<double>(j) + 0.5) / static_cast<double>(beams) - 0.5;
    settings.azimuth_rad.push_back(radians(config.azimuth_deg * part));
  }
  return {};
}

void take_amplitudes(const UnpickledArray& image, bool with_counts, NeusisFrame& found) {
  const auto samples = static_cast<std::size_t>(found.frame.settings.samples);
  const auto beams = static_cast<std::size_t>(found.frame.settings.beams);
  const std::vector<double> amplitudes = values_of(image);
  found.cut = amplitudes.size() > samples * beams;
  for (std::size_t n = 0; n < samples; ++n) {
    for (std::size_t j = 0; j < beams; ++j) {
      const double amplitude = amplitudes[n * image.shape[1] + j];
      const bool inside = amplitude >= 0 && amplitude <= 1;
      found.clipped += !inside;
      const double kept = std::isnan(amplitude) ? 0 : std::clamp(amplitude, 0.0, 1.0);
      if (with_counts) {
        put_value(found.frame.counts, static_cast<std::uint16_t>(std::lround(kFullScale * kept)));
      }
    }
  }
}

class NeusisFolder {
 public:
  NeusisFolder(fs::path path, std::string name, NeusisConfig config, std::vector<std::string> names,
               const LogChoices& choices)
      : path_(std::move(path)),
        name_(std::move(name)),
        config_(std::move(config)),
        names_(std::move(names)),
        frequency_hz_(choices.frequency_hz) {}

  Result<LogEnd> read(const LogFrames& frames) const {
    std::optional<LogSettings> first;
    std::uint64_t clipped = 0, cut = 0;
    bool posed = false;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const fs::path path = path_ / names_[i];
      const auto bytes = read_file(path, kMostPickleBytes);
      if (!bytes) return bytes.error();
      auto found = parse_neusis_frame(config_, *bytes, path.string(), frames.wants_counts(i));
      if (!found) return found.error();
      LogFrame& frame = found->frame;
      frame.offset = i;
      frame.time_us =
          std::llround(1e6 * static_cast<double>(i) / config_.rate_hz.value_or(kAssumedRate_hz));
      frame.settings.instrument = name_;
      frame.settings.frequency_hz = frequency_hz_.value_or(kAssumedFrequency_hz);
      clipped += found->clipped;
      cut += found->cut;
      if (!first) first = frame.settings;
      if (first->samples != frame.settings.samples || first->beams != frame.settings.beams) {
        return Error{ErrorKind::usage,
                     fmt::format("{}: {} x {} pixels; the first image has {} x {}", path.string(),
                                 frame.settings.samples, frame.settings.beams, first->samples,
                                 first->beams)};
      }
      if (i == 0) posed = frame.sonar_in_world.has_value();
      if (posed != frame.sonar_in_world.has_value()) {
        return Error{ErrorKind::usage,
                     fmt::format("{}: has {} {}, unlike the first file; expected it in all files "
                                 "or in none",
                                 path.string(), posed ? "no" : "a", kPoseKey)};
      }
      if (const Status used = frames.use(i, frame); !used) return used.error();
    }
    return LogEnd{names_.size(), warning(clipped, cut)};
  }

  Result<std::string> sha256() const {
    Sha256 all;
    std::vector<std::string> files = names_;
    files.insert(files.begin(), kConfig);
    for (const std::string& file : files) {
      const auto hash = sha256_of_file(path_ / file);
      if (!hash) return hash.error();
      all.update(*hash + "  " + file + "\n");
    }
    return all.finish();
  }

 private:
  std::string warning(std::uint64_t clipped, std::uint64_t cut) const {
    std::string text;
    const auto add = [&](const std::string& what) {
      text += (text.empty() ? "" : "\n") + name_ + ": " + what;
    };
    if (!frequency_hz_) {
      add(fmt::format("{} has no frequency; {:g} kHz is assumed, or give --frequency-hz", kConfig,
                      kAssumedFrequency_hz / 1e3));
    }
    if (!config_.rate_hz) add(fmt::format("{} has no Hz; one ping per second is assumed", kConfig));
    if (cut > 0) {
      add(counted(cut, "image") + " larger than " + kConfig + " says, which were cut to its size");
    }
    if (clipped > 0) add(counted(clipped, "pixel") + " outside of 0 to 1, which were clipped");
    return text;
  }

  fs::path path_;
  std::string name_;
  NeusisConfig config_;
  std::vector<std::string> names_;
  std::optional<double> frequency_hz_;
};

// Data/*.pkl, by number.
Result<std::vector<std::string>> pickles_of(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder / kData, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() == kPickleEnd) names.push_back(entry->path().filename());
  }
  if (error && error != std::errc::no_such_file_or_directory) {
    return Error{ErrorKind::io,
                 fmt::format("{}: cannot be read: {}", (folder / kData).string(), error.message())};
  }
  if (names.empty()) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: has no {} files; expected those of {} and {}",
                             (folder / kData).string(), kPickleEnd, kSonarKey, kPoseKey)};
  }
  sort_naturally(names);
  for (std::string& name : names) name = std::string(kData) + "/" + name;
  return names;
}

}  // namespace

bool is_neusis(const fs::path& folder) {
  std::error_code error;
  return fs::is_regular_file(folder / kConfig, error);
}

Result<NeusisConfig> parse_neusis_config(std::string_view text, const std::string& place) {
  const auto refused = [&](const std::string& what) {
    return Error{ErrorKind::usage, place + ": " + what};
  };
  const auto json = parse_json(text);
  if (!json) return refused("is not JSON");
  const Json* sensor = sensor_of(*json);
  const Json* found = sensor == nullptr ? nullptr : member(*sensor, "configuration");
  if (found == nullptr) {
    return refused(
        "has no sensor with a configuration in agents[].sensors[]; expected one of type "
        "ImagingSonar");
  }
  NeusisConfig config;
  config.azimuth_deg = number_at(*found, "Azimuth").value_or(0);
  config.range_min_m = number_at(*found, "RangeMin").value_or(0);
  config.range_max_m = number_at(*found, "RangeMax").value_or(-1);
  config.range_bins = count_at(*found, "RangeBins");
  config.azimuth_bins = count_at(*found, "AzimuthBins");
  config.rate_hz = number_at(*sensor, "Hz");
  if (!(config.azimuth_deg >= 1e-3 && config.azimuth_deg <= 360)) {
    return refused("configuration.Azimuth: expected the degrees of the fan, up to 360");
  }
  const double span_m = config.range_max_m - config.range_min_m;
  if (!(config.range_min_m >= 0 && span_m >= 1e-3 && config.range_max_m <= 1e5 &&
        config.range_min_m / span_m < 10)) {
    return refused("configuration.RangeMin, RangeMax: expected meters that rise from 0");
  }
  if (config.rate_hz && !(*config.rate_hz >= 1e-6 && *config.rate_hz <= 1e6)) {
    return refused("Hz: expected a ping rate of 1e-6 to 1e6");
  }
  return config;
}

Result<NeusisFrame> parse_neusis_frame(const NeusisConfig& config, std::string_view pickle,
                                       const std::string& place, bool with_counts) {
  const auto refused = [&](const std::string& what) {
    return Error{ErrorKind::usage, place + ": " + what};
  };
  const auto unpickled = unpickle_arrays(pickle);
  if (!unpickled) return refused(unpickled.error().message);
  const auto image = unpickled->arrays.find(kSonarKey);
  if (image == unpickled->arrays.end()) return refused(fmt::format("has no array {}", kSonarKey));
  NeusisFrame found;
  std::string fault = take_pickled_axes(config, image->second, found.frame.settings);
  const auto pose = unpickled->arrays.find(kPoseKey);
  if (fault.empty() && pose != unpickled->arrays.end()) {
    fault = take_pickled_pose(pose->second, found.frame);
  }
  if (!fault.empty()) return refused(fault);
  take_amplitudes(image->second, with_counts, found);
  return found;
}

Result<Log> open_neusis(const fs::path& folder, const LogChoices& choices) {
  const auto text = read_file(folder / kConfig, std::uint64_t{1} << 24);
  if (!text) return text.error();
  auto config = parse_neusis_config(*text, (folder / kConfig).string());
  if (!config) return config.error();
  auto names = pickles_of(folder);
  if (!names) return names.error();
  fs::path whole = fs::absolute(folder).lexically_normal();
  if (whole.filename().empty()) whole = whole.parent_path();
  const std::string name = whole.filename();
  const auto opened =
      std::make_shared<const NeusisFolder>(folder, name, *config, std::move(*names), choices);
  return Log{LogFormat::neusis, name,
             [opened](const LogFrames& frames) { return opened->read(frames); },
             [opened] { return opened->sha256(); }};
}

}  // namespace ensonify
