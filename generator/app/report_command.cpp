#include <fmt/format.h>

#include <cstdio>

#include "app/commands.h"
#include "app/interrupt.h"

namespace ensonify {

Status report_command(const ReportOptions& given, bool quiet) {
  listen_for_interrupts();
  ReportOptions options = given;
  options.stop = interrupted;
  const Result<ReportSummary> summary = write_report(options);
  if (!summary) return summary.error();
  if (!quiet) {
    fmt::print(stderr, "{}: {} of {} pings, {:.1f} MB\n", summary->output.string(), summary->shown,
               summary->pings, static_cast<double>(summary->bytes) / 1e6);
  }
  return {};
}

}  // namespace ensonify
