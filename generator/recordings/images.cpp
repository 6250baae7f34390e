#include "recordings/images.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/counted.h"
#include "core/units.h"
#include "formats/bytes.h"
#include "formats/files.h"
#include "formats/natural_order.h"
#include "formats/npy.h"
#include "formats/png.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

constexpr char kDescription[] = "recording.yaml";
constexpr std::uint64_t kMostImageBytes = std::uint64_t{1} << 28;

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

void take_scale(Keys& keys, const YAML::Node& map, ImageFolder& folder) {
  keys.value<YAML::Node>("scale");
  const YAML::Node scale = map["scale"];
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

// Whether the name matches a pattern with *. Each * takes as little as it can; at a mismatch the
// last one takes more.
bool matches(std::string_view pattern, std::string_view name) {
  std::size_t p = 0, n = 0, star = std::string_view::npos, after = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      after = n;
    } else if (p < pattern.size() && pattern[p] == name[n]) {
      ++p;
      ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++after;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

// Pixels of an image as little-endian counts.
struct Image {
  std::uint64_t rows = 0, columns = 0;
  int bits = 8;
  std::string counts;
};

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

Result<Image> parse_image(const fs::path& path, std::string_view bytes) {
  const auto wrong = [&](const std::string& what) {
    return Error{ErrorKind::usage, path.string() + ": " + what};
  };
  if (parse_png_header(bytes)) {
    const auto png = parse_grey_png(bytes);
    if (!png) return wrong(png.error().message);
    const bool words = !png->grey16.empty();
    return Image{png->rows, png->columns, words ? 16 : 8,
                 words ? bytes_of(png->grey16) : bytes_of(png->grey8)};
  }
  const auto header = parse_npy_header(bytes);
  if (!header) return wrong("neither a grayscale PNG nor an NPY file");
  const bool is_bytes = header->descr == kNpyUint8, words = header->descr == kNpyUint16;
  if ((!is_bytes && !words) || header->fortran_order || header->shape.size() != 2) {
    return wrong("an array of another kind; expected uint8 or uint16 [rows, columns] in C order");
  }
  const std::uint64_t rows = header->shape[0], columns = header->shape[1];
  const std::string_view data =
      bytes.substr(std::min<std::uint64_t>(header->data_offset, bytes.size()));
  if (rows > kMostLogSamples || columns > kMostLogBeams ||
      data.size() != rows * columns * (words ? 2 : 1)) {
    return wrong("does not have the length that its header gives");
  }
  return Image{rows, columns, words ? 16 : 8, std::string(data)};
}

class Folder {
 public:
  Folder(fs::path path, ImageFolder about, std::vector<std::string> names)
      : path_(std::move(path)), about_(std::move(about)), names_(std::move(names)) {}

  Result<LogEnd> read(const LogFrames& frames) const {
    std::optional<LogSettings> settings;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const bool wanted = frames.wants_counts(i);
      LogFrame frame;
      frame.offset = i;
      frame.time_us =
          std::llround(1e6 * (about_.times_s.empty() ? static_cast<double>(i) / about_.ping_rate_hz
                                                     : about_.times_s[i]));
      // Images without counts are read too, so that a bad one is known before anything is written.
      auto image = image_of(names_[i], settings);
      if (!image) return image.error();
      if (!settings) settings = settings_of(*image);
      if (wanted) frame.counts = counts_of(*image);
      frame.settings = *settings;
      if (const Status used = frames.use(i, frame); !used) return used.error();
    }
    return LogEnd{names_.size(), {}};
  }

  Result<std::string> sha256() const {
    Sha256 all;
    std::vector<std::string> files = names_;
    files.insert(files.begin(), kDescription);
    for (const std::string& name : files) {
      const auto hash = sha256_of_file(path_ / name);
      if (!hash) return hash.error();
      all.update(*hash + "  " + name + "\n");
    }
    return all.finish();
  }

 private:
  Result<Image> image_of(const std::string& name, const std::optional<LogSettings>& first) const {
    const fs::path path = path_ / name;
    std::error_code error;
    if (fs::file_size(path, error) > kMostImageBytes || error) {
      return Error{ErrorKind::usage, path.string() + ": is missing or larger than 256 MiB"};
    }
    const auto bytes = read_file(path);
    if (!bytes) return bytes.error();
    auto image = parse_image(path, *bytes);
    if (!image) return image;
    const auto wrong = [&](const std::string& what) {
      return Error{ErrorKind::usage, fmt::format("{}: {} x {} pixels of {} bits; {}", path.string(),
                                                 image->columns, image->rows, image->bits, what)};
    };
    if (image->rows < 2 || image->columns < 2 || image->rows > kMostLogSamples ||
        image->columns > kMostLogBeams) {
      return wrong("expected at least 2 x 2");
    }
    const std::size_t azimuths = about_.azimuth_deg.size();
    if (azimuths > 0 && azimuths != image->columns) {
      return wrong(fmt::format("azimuth_deg of {} has {} values", kDescription, azimuths));
    }
    if (first && (std::cmp_not_equal(first->samples, image->rows) ||
                  std::cmp_not_equal(first->beams, image->columns) || first->bits != image->bits)) {
      return wrong(fmt::format("the first image has {} x {} of {}", first->beams, first->samples,
                               first->bits));
    }
    return image;
  }

  LogSettings settings_of(const Image& image) const {
    LogSettings settings;
    settings.instrument = about_.instrument;
    settings.beams = static_cast<int>(image.columns);
    settings.samples = static_cast<int>(image.rows);
    settings.bits = image.bits;
    settings.db = about_.db;
    settings.gamma = about_.gamma;
    settings.frequency_hz = about_.frequency_hz;
    settings.sound_speed_m_s = about_.sound_speed_m_s;
    settings.first_range_m = about_.first_range_m;
    settings.range_step_m =
        (about_.last_range_m - about_.first_range_m) / static_cast<double>(image.rows - 1);
    const auto beams = static_cast<double>(image.columns);
    for (std::size_t j = 0; j < image.columns; ++j) {
      const double equal = about_.fan_deg * ((static_cast<double>(j) + 0.5) / beams - 0.5);
      settings.azimuth_rad.push_back(
          radians(about_.azimuth_deg.empty() ? equal : about_.azimuth_deg[j]));
    }
    std::sort(settings.azimuth_rad.begin(), settings.azimuth_rad.end());
    return settings;
  }

  // Nearest row and starboard first.
  std::string counts_of(const Image& image) const {
    const std::size_t width = static_cast<std::size_t>(image.bits / 8);
    std::string counts(image.counts.size(), '\0');
    for (std::uint64_t row = 0; row < image.rows; ++row) {
      const std::uint64_t from_row = about_.near_first ? row : image.rows - 1 - row;
      for (std::uint64_t column = 0; column < image.columns; ++column) {
        const std::uint64_t from = about_.port_first ? image.columns - 1 - column : column;
        counts.replace((row * image.columns + column) * width, width, image.counts,
                       (from_row * image.columns + from) * width, width);
      }
    }
    return counts;
  }

  fs::path path_;
  ImageFolder about_;
  std::vector<std::string> names_;
};

Result<ImageFolder> folder_from(const YAML::Node& map, const std::string& place) {
  ImageFolder folder;
  Keys keys(map);
  folder.files = keys.value<std::string>("files").value_or("");
  if (folder.files.empty()) keys.refuse("files: expected names of images, such as \"*.png\"");
  take_fan(keys, folder);
  take_axes(keys, folder);
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

bool is_image_folder(const fs::path& folder) {
  std::error_code error;
  return fs::is_regular_file(folder / kDescription, error);
}

Result<Log> open_images(const fs::path& path) {
  const fs::path description = path / kDescription;
  if (!is_image_folder(path)) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: has neither {}, which describes a folder of polar images, nor "
                             "Config.json, of a set of neusis (docs/recordings.md)",
                             path.string(), kDescription)};
  }
  const auto text = read_file(description, std::uint64_t{1} << 24);
  if (!text) return text.error();
  auto about = parse_image_folder(*text, description.string());
  if (!about) return about.error();
  const std::string name = fs::absolute(path).lexically_normal().filename().empty()
                               ? fs::absolute(path).lexically_normal().parent_path().filename()
                               : fs::absolute(path).lexically_normal().filename();
  if (about->instrument.empty()) about->instrument = name;
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(path, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string file = entry->path().filename();
    if (file != kDescription && matches(about->files, file)) names.push_back(file);
  }
  if (error) return read_error(path, error.value());
  sort_naturally(names);
  if (names.empty() || (!about->times_s.empty() && about->times_s.size() != names.size())) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: {} match \"{}\"; expected {}", description.string(),
                             counted(names.size(), "file"), about->files,
                             about->times_s.empty() ? "at least one"
                                                    : fmt::format("one for each of the {} times_s",
                                                                  about->times_s.size()))};
  }
  const auto folder = std::make_shared<const Folder>(path, std::move(*about), std::move(names));
  return Log{LogFormat::images, name,
             [folder](const LogFrames& frames) { return folder->read(frames); },
             [folder] { return folder->sha256(); }};
}

}  // namespace ensonify
