#include "scenario/tables.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "core/units.h"
#include "scenario/faults.h"
#include "scenario/reader.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

// About 50,000 rows, more than any pulse or seabed needs.
constexpr std::size_t kMaxTableBytes = 1u << 20;

constexpr double kMaxGrazingStepDeg = 10;
constexpr double kTableRounding = 1e-9;

struct Column {
  std::string_view name;
  NumberRange range;
};

// A row with unreadable fields has no values, so that its neighbors are not compared with it.
struct Row {
  std::size_t line = 0;
  std::vector<double> values;  // in the order of the wanted columns
};

struct Table {
  std::string file;
  std::size_t header_line = 1;
  std::vector<Row> rows;
  std::vector<std::string> faults;
  std::size_t left_out = 0;
};

void tell(Table& table, std::size_t line, const std::string& text) {
  if (table.faults.size() < kMaxFaults) {
    table.faults.push_back(one_line(fmt::format("{}:{}: {}", table.file, line, text)));
  } else {
    ++table.left_out;
  }
}

Error to_error(const Table& table) {
  std::vector<std::string> lines = table.faults;
  if (table.left_out > 0) lines.push_back(fmt::format("and {} more", table.left_out));
  return {ErrorKind::usage, fmt::format("{}", fmt::join(lines, "\n"))};
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

// Spreadsheets put names, and some all cells, in quotes.
std::string_view unquoted(std::string_view cell) {
  if (cell.size() < 2 || cell.front() != '"' || cell.back() != '"') return cell;
  return trimmed(cell.substr(1, cell.size() - 2));
}

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(unquoted(trimmed(line.substr(0, comma))));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

std::vector<std::string_view> names_of(const std::vector<Column>& columns) {
  std::vector<std::string_view> names;
  for (const Column& column : columns) names.push_back(column.name);
  return names;
}

// For each field of the header, the column that it names; empty if the header is wrong.
std::optional<std::vector<std::size_t>> read_header(Table& table, std::string_view header,
                                                    const std::vector<Column>& columns) {
  const std::vector<std::string_view> names = names_of(columns);
  std::vector<std::size_t> order;
  for (const std::string_view field : fields_of(header)) {
    if (table.faults.size() >= kMaxFaults) return std::nullopt;
    const auto found = std::find(names.begin(), names.end(), field);
    const auto index = static_cast<std::size_t>(found - names.begin());
    if (found == names.end()) {
      tell(table, table.header_line,
           fmt::format("unknown column {}{}; expected {}", shown(field), hint(field, names),
                       joined(names)));
    } else if (std::find(order.begin(), order.end(), index) != order.end()) {
      tell(table, table.header_line, fmt::format("column {} is given twice; expected once", field));
    } else {
      order.push_back(index);
    }
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::find(order.begin(), order.end(), i) != order.end()) continue;
    tell(table, table.header_line,
         fmt::format("column {} is missing; expected a first line with {}", names[i],
                     joined(names)));
  }
  if (!table.faults.empty()) return std::nullopt;
  return order;
}

std::optional<double> number_of(std::string_view field) {
  // from_chars does not accept a leading plus sign.
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), number);
  if (error != std::errc{} || end != field.data() + field.size()) return std::nullopt;
  if (!std::isfinite(number)) return std::nullopt;
  return number + 0.0;  // -0 becomes 0
}

void read_row(Table& table, std::size_t line, std::string_view text,
              const std::vector<Column>& columns, const std::vector<std::size_t>& order) {
  Row row{line, {}};
  const std::vector<std::string_view> fields = fields_of(text);
  if (fields.size() != columns.size()) {
    tell(table, line,
         fmt::format("the row has {} fields; expected {} as in the first line", fields.size(),
                     columns.size()));
    table.rows.push_back(row);
    return;
  }
  std::vector<double> values(columns.size());
  bool whole = true;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const Column& column = columns[order[i]];
    const std::optional<double> number = number_of(fields[i]);
    std::string trouble;
    if (fields[i].empty()) {
      trouble = "the field is empty";
    } else if (!number) {
      trouble = shown(fields[i]) + " is not a finite number";
    } else if (*number < column.range.low || *number > column.range.high) {
      trouble = shown(fields[i]) + " is out of range";
    }
    if (trouble.empty()) {
      values[order[i]] = *number;
      continue;
    }
    whole = false;
    tell(
        table, line,
        fmt::format("{}: {}; expected {}", column.name, trouble, in_words(column.range, "number")));
  }
  if (whole) row.values = std::move(values);
  table.rows.push_back(std::move(row));
}

void read_lines(Table& table, std::string_view text, const std::vector<Column>& columns) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::optional<std::vector<std::size_t>> order;
  std::size_t line = 0;
  while (!text.empty()) {
    ++line;
    const std::size_t newline = text.find('\n');
    const std::string_view content = trimmed(text.substr(0, newline));
    text.remove_prefix(newline == std::string_view::npos ? text.size() : newline + 1);
    if (content.empty() || content.starts_with('#')) continue;
    if (order) {
      read_row(table, line, content, columns, *order);
      continue;
    }
    table.header_line = line;
    order = read_header(table, content, columns);
    if (!order) return;
  }
  if (order) return;
  tell(table, 1,
       fmt::format("the file is empty; expected a first line with {}", joined(names_of(columns))));
}

// Returns the rows of the file and the errors of each row by itself.
Result<Table> read_table(const std::filesystem::path& file, const std::vector<Column>& columns) {
  Table table;
  table.file = file.string();
  std::ifstream stream(file, std::ios::binary);
  // Reads one byte more than the limit, so that an endless pipe ends and is refused.
  std::string text(kMaxTableBytes + 1, '\0');
  if (stream) stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!stream.is_open() || stream.bad()) {
    return Error{ErrorKind::io, one_line(fmt::format("{}: cannot be read", table.file))};
  }
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > kMaxTableBytes) {
    tell(table, 1, fmt::format("larger than {} MiB", kMaxTableBytes >> 20));
  } else {
    read_lines(table, text, columns);
  }
  return table;
}

// Checks that the first column increases, and calls `compare(before, row)` where it does.
template <class Compare>
void check_neighbours(Table& table, std::string_view what, Compare compare) {
  for (std::size_t i = 1; i < table.rows.size(); ++i) {
    const Row& before = table.rows[i - 1];
    const Row& row = table.rows[i];
    if (before.values.empty() || row.values.empty()) continue;
    if (row.values[0] > before.values[0]) {
      compare(before, row);
      continue;
    }
    tell(table, row.line,
         fmt::format(
             "{} is not above the {} in the row before; expected {} that increase from row to row",
             row.values[0], before.values[0], what));
  }
}

// A phase that stays within one turn may be wrapped, so its steps are taken the shorter way around.
// A phase that exceeds one turn must change by less than half a turn per row.
void check_phase_steps(Table& table) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Row& row : table.rows) {
    if (row.values.empty()) continue;
    low = std::min(low, row.values[2]);
    high = std::max(high, row.values[2]);
  }
  const bool runs_on = high - low > 360;
  check_neighbours(table, "frequencies", [&](const Row& before, const Row& row) {
    const double step = row.values[2] - before.values[2];
    const double short_way = runs_on ? step : std::remainder(step, 360.0);
    if (std::abs(short_way) < 180 - kTableRounding) return;
    tell(table, row.line,
         fmt::format("phase_deg: a step of {} degrees is ambiguous; expected rows so close that "
                     "the phase changes by less than 180",
                     step));
  });
}

void check_band(Table& table, const Sonar& sonar) {
  const double low = sonar.frequency_hz - sonar.bandwidth_hz / 2;
  const double high = sonar.frequency_hz + sonar.bandwidth_hz / 2;
  bool inside = false, loud = false;
  for (const Row& row : table.rows) {
    const bool in_band = row.values[0] > low && row.values[0] < high;
    inside = inside || in_band;
    loud = loud || (in_band && row.values[1] > 0);
  }
  if (loud) return;
  tell(table, table.header_line,
       fmt::format(
           "{} in the sonar's band of {} to {} Hz; expected at least one amplitude above zero",
           inside ? "all amplitudes are zero" : "there is no row", low, high));
}

}  // namespace

Result<std::vector<PulseTableRow>> load_pulse_table(const std::filesystem::path& file,
                                                    const Sonar& sonar) {
  // With these bounds the squares and sums of any table are finite.
  Result<Table> table = read_table(file, {{"frequency_hz", from_to(0, 1e10)},
                                          {"amplitude", from_to(0, 1e30)},
                                          {"phase_deg", from_to(-1e9, 1e9)}});
  if (!table) return table.error();
  check_phase_steps(*table);
  if (table->faults.empty() && table->rows.size() < 2) {
    tell(*table, table->header_line,
         fmt::format("the number of rows is {}; expected 2 or more", table->rows.size()));
  }
  if (table->faults.empty()) check_band(*table, sonar);
  if (!table->faults.empty()) return to_error(*table);
  std::vector<PulseTableRow> rows;
  for (const Row& row : table->rows) {
    rows.push_back({row.values[0], row.values[1], radians(row.values[2])});
  }
  return rows;
}

Result<BackscatterTable> load_backscatter_table(const std::filesystem::path& file) {
  Result<Table> table =
      read_table(file, {{"grazing_deg", from_to(0, 90)}, {"strength_db", from_to(-200, 100)}});
  if (!table) return table.error();
  check_neighbours(*table, "angles", [&](const Row& before, const Row& row) {
    const double step = row.values[0] - before.values[0];
    if (step <= kMaxGrazingStepDeg + kTableRounding) return;
    tell(*table, row.line,
         fmt::format("there are {} degrees between this row and the one before; expected at most "
                     "{}, because gaps are not filled",
                     step, kMaxGrazingStepDeg));
  });
  if (table->rows.empty() && table->faults.empty()) {
    tell(*table, table->header_line, "there are no rows; expected rows from 0 to 90 degrees");
  }
  if (!table->rows.empty()) {
    const Row& first = table->rows.front();
    const Row& last = table->rows.back();
    if (!first.values.empty() && first.values[0] != 0) {
      tell(*table, first.line,
           fmt::format("the first row is at {} degrees; expected 0 (along the surface)",
                       first.values[0]));
    }
    if (!last.values.empty() && last.values[0] != 90) {
      tell(*table, last.line,
           fmt::format("the last row is at {} degrees; expected 90 (normal to the surface)",
                       last.values[0]));
    }
  }
  if (!table->faults.empty()) return to_error(*table);
  BackscatterTable result;
  for (const Row& row : table->rows) {
    result.grazing_rad.push_back(radians(row.values[0]));
    result.strength_db.push_back(row.values[1]);
  }
  result.grazing_rad.back() = kPi / 2;  // exactly, so that no angle is beyond it
  return result;
}

Result<SoundProfile> load_sound_profile(const std::filesystem::path& file) {
  Result<Table> table =
      read_table(file, {{"depth_m", from_to(kMinDepthM, kMaxDepthM)},
                        {"sound_speed_m_s", from_to(kMinSoundSpeed, kMaxSoundSpeed)}});
  if (!table) return table.error();
  check_neighbours(*table, "depths", [](const Row&, const Row&) {});
  if (table->rows.empty() && table->faults.empty()) {
    tell(*table, table->header_line, "there are no rows; expected one or more");
  }
  if (!table->faults.empty()) return to_error(*table);
  SoundProfile profile;
  for (const Row& row : table->rows) {
    profile.depth_m.push_back(row.values[0]);
    profile.speed_m_s.push_back(row.values[1]);
  }
  return profile;
}

}  // namespace ensonify
