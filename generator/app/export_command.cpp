#include <fmt/format.h>

#include <cstdio>

#include "app/commands.h"
#include "app/interrupt.h"
#include "app/print.h"
#include "scenario/text.h"

namespace ensonify {

Status export_command(const std::string& format_name, ExportOptions options, bool quiet) {
  const ExportFormat* format = find_export_format(format_name);
  if (format == nullptr) {
    std::vector<std::string_view> names;
    for (const ExportFormat& known : export_formats()) names.emplace_back(known.name);
    return Error{ErrorKind::usage,
                 fmt::format("--format {}: unknown{}; accepted is {}", one_line(format_name),
                             hint(format_name, names), joined(names))};
  }
  listen_for_interrupts();
  options.stop = interrupted;
  const auto report = export_dataset(*format, options);
  if (!report) return report.error();
  if (!quiet) {
    tell("{}: {} pings of {} sequences as {}\n", options.output.string(), report->pings,
         report->sequences, format->name);
  }
  return {};
}

std::string export_format_list() {
  std::string text = "formats (docs/export.md):\n";
  for (const ExportFormat& format : export_formats()) {
    text += fmt::format("  {:<12} {}{}{}\n", format.name, format.what,
                        *format.options != '\0' ? "; takes " : "", format.options);
  }
  return text;
}

}  // namespace ensonify
