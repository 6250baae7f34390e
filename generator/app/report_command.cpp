
#include <cstdio>

#include "app/commands.h"
#include "app/interrupt.h"
#include "app/print.h"

namespace ensonify {

Status report_command(const ReportOptions& given, bool quiet) {
  listen_for_interrupts();
  ReportOptions options = given;
  options.stop = interrupted;
  const Result<ReportSummary> summary = write_report(options);
  if (!summary) return summary.error();
  if (!quiet) {
    tell("{}: {} of {} pings, {:.1f} MB\n", summary->output.string(), summary->shown,
         summary->pings, static_cast<double>(summary->bytes) / 1e6);
  }
  return {};
}

}  // namespace ensonify
