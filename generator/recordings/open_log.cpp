#include "recordings/open_log.h"

#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "formats/files.h"
#include "formats/natural_order.h"
#include "recordings/aris.h"
#include "recordings/images.h"
#include "recordings/mcap.h"
#include "recordings/neusis.h"
#include "recordings/oculus.h"

namespace ensonify {
namespace {

// Of equal length, as they are read: the begin of a bag of ROS 1, and of a database of SQLite 3.
constexpr std::string_view kBagHead = "#ROSBAG V2.0", kSqliteHead = "SQLite forma";

// The error about a folder that rosbag2 has recorded, which names what to import in its place;
// none for another folder.
std::optional<Error> bag_folder(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(folder / "metadata.yaml", error)) return std::nullopt;
  std::vector<std::string> mcaps, databases;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string ending = entry->path().extension();
    if (ending == ".mcap") mcaps.push_back(entry->path().string());
    if (ending == ".db3") databases.push_back(entry->path().string());
  }
  if (mcaps.empty() && databases.empty()) return std::nullopt;
  sort_naturally(mcaps);
  sort_naturally(databases);
  std::string files;
  for (const std::string& file : mcaps) files += (files.empty() ? "" : ", ") + file;
  const std::string of = folder.string() + ": a recording of rosbag2; ";
  if (mcaps.size() == 1) return Error{ErrorKind::usage, of + "expected the file in it, " + files};
  if (mcaps.size() > 1) {
    return Error{ErrorKind::usage, of +
                                       "expected one of the files in it, each a data set of its "
                                       "own: " +
                                       files};
  }
  return Error{ErrorKind::usage,
               of + "its messages are in a database; expected an MCAP file, which `mcap convert " +
                   databases.front() + " FILE.mcap` writes (the tool of mcap.dev)"};
}

}  // namespace

Result<LogFormat> log_format_of(const LogBytes& log) {
  if (log.size < sizeof(std::uint32_t)) {
    return log_error(log, 0, "ends here; expected an .aris or .oculus log");
  }
  const auto head = log.read(0, sizeof(std::uint32_t));
  if (!head) return head.error();
  if (is_aris(*head)) return LogFormat::aris;
  if (is_oculus(*head)) return LogFormat::oculus;
  if (is_mcap(*head)) return LogFormat::mcap;
  if (is_didson(*head)) {
    return log_error(log, 0,
                     "a DIDSON file of version 3 or 4; expected an ARIS file (version 5), to which "
                     "the manufacturer's software converts it");
  }
  if (log.size >= kBagHead.size() + 1) {
    const auto longer = log.read(0, kBagHead.size());
    if (!longer) return longer.error();
    if (*longer == kBagHead) {
      return log_error(
          log, 0,
          "a bag of ROS 1; expected an MCAP file of ROS 2, which `pip install rosbags` "
          "and `rosbags-convert --src FILE.bag --dst FOLDER --dst-storage mcap` write "
          "into FOLDER");
    }
    if (longer->starts_with(kSqliteHead)) {
      return log_error(
          log, 0,
          "a database (.db3), as older rosbag2 records; expected an MCAP file, which `mcap "
          "convert FILE.db3 FILE.mcap` writes (the tool of mcap.dev)");
    }
  }
  return log_error(log, 0,
                   "neither an .aris file (44 44 46 05) nor an .oculus log (44 33 22 11), a stream "
                   "of Oculus messages (53 4f) or an MCAP file (89 4d 43 41)");
}

Result<LogEnd> read_log(LogFormat format, const LogBytes& log, const LogFrames& frames,
                        const LogChoices& choices) {
  ENSONIFY_ASSERT(format != LogFormat::images && format != LogFormat::neusis);
  const auto end = format == LogFormat::aris   ? read_aris(log, frames)
                   : format == LogFormat::mcap ? read_mcap(log, frames, choices)
                                               : read_oculus(log, frames);
  if (!end || end->frames > 0) return end;
  return log_error(log, log.size,
                   "the log has no whole frame; record again, or check that the file was copied "
                   "to its end");
}

Result<Log> open_log(const std::filesystem::path& path, const LogChoices& choices) {
  const auto refused = [&](const char* what) {
    return Error{ErrorKind::usage, path.string() + ": " + what};
  };
  const bool chosen = !choices.topic.empty() || choices.db;
  constexpr char kOfMcap[] = "--topic and --db are options of MCAP files only";
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(path, error);
  if (is_folder && !is_image_folder(path)) {
    if (const std::optional<Error> bag = bag_folder(path)) return *bag;
  }
  const bool pickled = is_folder && !is_image_folder(path) && is_neusis(path);
  if (choices.frequency_hz && !pickled) {
    return refused("--frequency-hz is an option of sets of neusis only");
  }
  if (is_folder && chosen) return refused(kOfMcap);
  if (is_folder) return pickled ? open_neusis(path, choices) : open_images(path);
  auto bytes = file_log(path);
  if (!bytes) return bytes.error();
  const auto format = log_format_of(*bytes);
  if (!format) return format.error();
  if (chosen && *format != LogFormat::mcap) return refused(kOfMcap);
  const std::string name = bytes->name;
  return Log{*format, name,
             [bytes = std::move(*bytes), choices, kind = *format](const LogFrames& frames) {
               return read_log(kind, bytes, frames, choices);
             },
             [path] { return sha256_of_file(path); }};
}

}  // namespace ensonify
