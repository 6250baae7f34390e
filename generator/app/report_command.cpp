#include "app/commands.h"
#include "app/interrupt.h"

namespace ensonify {

Status report_command(const ReportOptions& options, bool) {
  const Result<ReportSummary> summary = write_report(options);
  if (!summary) return summary.error();
  return {};
}

}  // namespace ensonify
