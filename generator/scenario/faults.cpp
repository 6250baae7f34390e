#include "scenario/faults.h"

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr std::size_t kMaxPathBytes = 300;

std::string line_of(const Faults& faults, const Fault& fault, ErrorPlaces places) {
  std::string line;
  if (places == ErrorPlaces::shown) {
    line = faults.sources[static_cast<std::size_t>(fault.place.source)];
    if (fault.place.line > 0) line += fmt::format(":{}:{}", fault.place.line, fault.place.column);
    line += ": ";
  }
  if (!fault.path.empty()) line += fault.path.substr(0, kMaxPathBytes) + ": ";
  return one_line(line + fault.text);
}

// The path without the indexes that distinguish items of a list.
std::string without_indexes(std::string_view path) {
  std::string kept;
  std::size_t begin = 0;
  while (begin <= path.size()) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const std::string_view segment = path.substr(begin, end - begin);
    kept += segment.find_first_not_of("0123456789") == std::string_view::npos ? "#" : segment;
    kept += '.';
    begin = end + 1;
  }
  return kept;
}

bool is_at(const Fault& fault, const Place& place, std::string_view path) {
  return place.line > 0 &&
         std::tie(fault.place.line, fault.place.column, fault.place.source) ==
             std::tie(place.line, place.column, place.source) &&
         without_indexes(fault.path) == without_indexes(path);
}

bool is_full(const Faults& faults) { return faults.list.size() >= kMaxFaults; }

}  // namespace

int add_source(Faults& faults, std::string label) {
  faults.sources.push_back(std::move(label));
  return static_cast<int>(faults.sources.size()) - 1;
}

void add_fault(Faults& faults, Place place, std::string_view path, std::string text) {
  const bool told = std::any_of(faults.list.begin(), faults.list.end(), [&](const Fault& fault) {
    return fault.text == text && is_at(fault, place, path);
  });
  if (told) {
    ++faults.repeated;
  } else if (is_full(faults)) {
    ++faults.left_out;
  } else {
    faults.list.push_back({place, std::string(path), std::move(text)});
  }
}

bool needs_words(Faults& faults, Place place, std::string_view path) {
  const bool told = std::any_of(faults.list.begin(), faults.list.end(),
                                [&](const Fault& fault) { return is_at(fault, place, path); });
  if (told) ++faults.repeated;
  if (!told && is_full(faults)) ++faults.left_out;
  return !told && !is_full(faults);
}

Error to_error(const Faults& faults, ErrorPlaces places) {
  std::vector<Fault> sorted = faults.list;
  std::stable_sort(sorted.begin(), sorted.end(), [&](const Fault& a, const Fault& b) {
    if (places == ErrorPlaces::hidden) return std::tie(a.path, a.text) < std::tie(b.path, b.text);
    return std::tie(a.place.source, a.place.line, a.place.column) <
           std::tie(b.place.source, b.place.line, b.place.column);
  });
  std::vector<std::string> lines;
  for (const Fault& fault : sorted) {
    std::string line = line_of(faults, fault, places);
    if (std::find(lines.begin(), lines.end(), line) == lines.end())
      lines.push_back(std::move(line));
  }
  if (faults.left_out > 0) lines.push_back(fmt::format("and {} more", faults.left_out));
  return {ErrorKind::usage, fmt::format("{}", fmt::join(lines, "\n"))};
}

}  // namespace ensonify
