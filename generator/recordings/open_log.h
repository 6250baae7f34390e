// Opens the logs of real sonars.
//
//   log_format_of  read_log   recognizes the format of bytes and reads them
//   open_log                  the same for a file or a folder
#pragma once

#include <filesystem>

#include "core/error.h"
#include "recordings/log.h"

namespace ensonify {

// By the first bytes. Error (usage): none of the formats, or a DIDSON file.
Result<LogFormat> log_format_of(const LogBytes& log);

// Calls `frames.use` for each frame and ends with its first Error. A frame that the end of the log
// cuts off is left out with a warning. Error (usage): anything else that the format does not allow,
// with the offset of the byte, or no frame at all; (io): the log cannot be read.
Result<LogEnd> read_log(LogFormat format, const LogBytes& log, const LogFrames& frames,
                        const LogChoices& choices = {});

// Errors: those of file_log, log_format_of, open_images and open_neusis; (usage) choices of another
// format.
Result<Log> open_log(const std::filesystem::path& path, const LogChoices& choices);

}  // namespace ensonify
