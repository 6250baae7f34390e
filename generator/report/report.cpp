#include "report/report.h"

namespace ensonify {

Result<ReportSummary> write_report(const ReportOptions&) {
  return Error{ErrorKind::bug, "not written yet"};
}

}  // namespace ensonify
