#include "scenario/faults.h"

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr std::size_t kMaxPathBytes = 300;

std::string line_of(const Faults& faults, const Fault& fault) {
  std::string line = faults.sources[static_cast<std::size_t>(fault.place.source)];
  if (fault.place.line > 0) line += fmt::format(":{}:{}", fault.place.line, fault.place.column);
  line += ": ";
  if (!fault.path.empty()) line += fault.path.substr(0, kMaxPathBytes) + ": ";
  return one_line(line + fault.text);
}

}  // namespace

int add_source(Faults& faults, std::string label) {
  faults.sources.push_back(std::move(label));
  return static_cast<int>(faults.sources.size()) - 1;
}

void add_fault(Faults& faults, Place place, std::string_view path, std::string text) {
  if (faults.list.size() < kMaxFaults) {
    faults.list.push_back({place, std::string(path), std::move(text)});
  } else {
    ++faults.left_out;
  }
}

Error to_error(const Faults& faults) {
  std::vector<Fault> sorted = faults.list;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Fault& a, const Fault& b) {
    return std::tie(a.place.source, a.place.line, a.place.column) <
           std::tie(b.place.source, b.place.line, b.place.column);
  });
  std::vector<std::string> lines;
  for (const Fault& fault : sorted) {
    std::string line = line_of(faults, fault);
    if (std::find(lines.begin(), lines.end(), line) == lines.end()) {
      lines.push_back(std::move(line));
    }
  }
  if (faults.left_out > 0) lines.push_back(fmt::format("and {} more", faults.left_out));
  return {ErrorKind::usage, fmt::format("{}", fmt::join(lines, "\n"))};
}

}  // namespace ensonify
