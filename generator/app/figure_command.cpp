#include <fmt/format.h>

#include <cstdio>

#include "app/commands.h"
#include "app/interrupt.h"
#include "app/print.h"
#include "scenario/text.h"

namespace ensonify {

Status figure_command(FigureOptions options, bool quiet) {
  if (options.title &&
      (first_invalid_utf8(*options.title) || first_control_character(*options.title, ""))) {
    return Error{ErrorKind::usage, "--title: accepted is one line of UTF-8 text"};
  }
  listen_for_interrupts();
  options.stop = interrupted;
  const auto report = write_figure(options);
  if (!report) return report.error();
  if (quiet) return {};
  std::string limits;
  if (report->limits) {
    const bool angle = options.channel == FigureChannel::elevation;
    limits = fmt::format(", {:g} to {:g} {}", (*report->limits)[0], (*report->limits)[1],
                         angle ? "degrees" : "dB");
  }
  tell("{}: {} {}{}\n", options.output.string(), report->frames,
       report->frames == 1 ? "ping" : "pings", limits);
  return {};
}

}  // namespace ensonify
