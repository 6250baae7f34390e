#include <fmt/format.h>

#include <algorithm>

#include "formats/bytes.h"
#include "formats/npy.h"
#include "scenario/text.h"
#include "world/grid_file.h"

namespace ensonify {
namespace {

Error wrong(const std::string& why) { return {ErrorKind::usage, why}; }

template <class T>
double number_at(std::string_view bytes, bool swapped) {
  std::string local(bytes.substr(0, sizeof(T)));
  if (swapped) std::reverse(local.begin(), local.end());
  return static_cast<double>(value_at<T>(local, 0));
}

struct NumberType {
  std::string_view name;
  std::size_t bytes;
  double (*at)(std::string_view, bool);
};
constexpr NumberType kTypes[] = {
    {"f4", 4, number_at<float>},        {"f8", 8, number_at<double>},
    {"i1", 1, number_at<std::int8_t>},  {"u1", 1, number_at<std::uint8_t>},
    {"i2", 2, number_at<std::int16_t>}, {"u2", 2, number_at<std::uint16_t>},
    {"i4", 4, number_at<std::int32_t>}, {"u4", 4, number_at<std::uint32_t>},
    {"i8", 8, number_at<std::int64_t>}, {"u8", 8, number_at<std::uint64_t>},
};

const NumberType* type_of(std::string_view name) {
  if (name.size() != 3 || std::string_view("<>|=").find(name[0]) == std::string_view::npos) {
    return nullptr;
  }
  for (const NumberType& type : kTypes) {
    if (type.name == name.substr(1) && (name[0] != '|' || type.bytes == 1)) return &type;
  }
  return nullptr;
}

}  // namespace

Result<GridFile> parse_npy_grid(std::string_view bytes) {
  const auto header = parse_npy_header(bytes);
  if (!header) return header.error();
  if (header->descr.starts_with('[')) {
    return wrong("is not an NPY file of plain numbers: its header cannot be read");
  }
  const std::string name = header->descr.substr(1, header->descr.size() - 2);
  const NumberType* type = type_of(name);
  if (type == nullptr) {
    return wrong(fmt::format("holds numbers of type {}; expected f4, f8, i1 to i8 or u1 to u8",
                             shown(name)));
  }
  if (header->shape.size() != 2) {
    return wrong(
        fmt::format("has {} dimensions; expected 2: rows from north to south, "
                    "columns from west to east",
                    header->shape.size()));
  }
  const auto rows = static_cast<std::int64_t>(header->shape[0]);
  const auto columns = static_cast<std::int64_t>(header->shape[1]);
  if (Status size = check_grid_size(rows, columns); !size) return size.error();
  const std::string_view data = bytes.substr(header->data_offset);
  const std::size_t count = header->shape[0] * header->shape[1];
  if (data.size() != count * type->bytes) {
    return wrong(
        fmt::format("holds {} bytes of numbers, but {} x {} of them take {}; it is cut "
                    "off or holds more than one array",
                    data.size(), rows, columns, count * type->bytes));
  }
  GridFile grid;
  grid.rows = static_cast<int>(rows);
  grid.columns = static_cast<int>(columns);
  grid.values.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at =
        header->fortran_order ? i % header->shape[1] * header->shape[0] + i / header->shape[1] : i;
    grid.values[i] = type->at(data.substr(at * type->bytes), name[0] == '>');
  }
  return grid;
}

}  // namespace ensonify
