#include "recordings/images.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/counted.h"
#include "core/units.h"
#include "formats/bytes.h"
#include "formats/files.h"
#include "formats/natural_order.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

constexpr char kDescription[] = "recording.yaml";

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
    return LogEnd{names_.size(), losses()};
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
  Result<LogImage> image_of(const std::string& name,
                            const std::optional<LogSettings>& first) const {
    const fs::path path = path_ / name;
    if (about_.display) return polar_of(path);
    auto image = read_log_image(path);
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

  // A display, with rows and columns as settings_of takes them.
  Result<LogImage> polar_of(const fs::path& path) const {
    LogImage cells{static_cast<std::uint64_t>(about_.samples),
                   static_cast<std::uint64_t>(about_.beams),
                   8,
                   {}};
    const LogSettings settings = settings_of(cells);
    std::vector<double> ranges;
    for (int i = 0; i < settings.samples; ++i) {
      ranges.push_back(settings.first_range_m + i * settings.range_step_m);
    }
    const std::vector<double> port_first(settings.azimuth_rad.rbegin(),
                                         settings.azimuth_rad.rend());
    return read_display(path, *about_.display, ranges, port_first);
  }

  LogSettings settings_of(const LogImage& image) const {
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

  // What a display does not hold; empty: the images are polar.
  std::string losses() const {
    if (!about_.display) return {};
    return fmt::format(
        "{}: made {} x {} polar cells of displays; what interpolation and the display's gain and 8 "
        "bits have changed is lost{}",
        path_.string(), about_.samples, about_.beams,
        about_.levels_are_grays
            ? "; levels are gray levels from 0 to 255, not dB (give scale: {db: [LOW, HIGH]})"
            : "");
  }

  // Nearest row and starboard first.
  std::string counts_of(const LogImage& image) const {
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

}  // namespace

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
