#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <optional>

#include "scenario/text.h"
#include "world/grid_file.h"

namespace ensonify {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kMaxHeaderBytes = 65536;

Error wrong(const std::string& why) { return {ErrorKind::usage, why}; }

// What is left to read of a header: {'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }
struct Header {
  std::string_view rest;

  void skip_blanks() {
    while (!rest.empty() && (rest.front() == ' ' || rest.front() == '\n')) rest.remove_prefix(1);
  }
  bool take(std::string_view token) {
    skip_blanks();
    if (!rest.starts_with(token)) return false;
    rest.remove_prefix(token.size());
    return true;
  }
  std::optional<std::string_view> text() {
    const char quote = take("'") ? '\'' : take("\"") ? '"' : '\0';
    const std::size_t end = rest.find(quote);
    if (quote == '\0' || end == std::string_view::npos) return std::nullopt;
    const std::string_view found = rest.substr(0, end);
    rest.remove_prefix(end + 1);
    return found;
  }
  std::optional<std::int64_t> integer() {
    skip_blanks();
    std::int64_t value = 0;
    const auto [end, failed] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (failed != std::errc{} || value < 0) return std::nullopt;
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    return value;
  }
};

struct Layout {
  std::optional<std::string_view> type;
  std::optional<bool> by_columns;
  std::vector<std::int64_t> shape;
  bool has_shape = false;
};

bool read_shape(Header& header, Layout& layout) {
  if (layout.has_shape || !header.take("(")) return false;
  layout.has_shape = true;
  while (!header.take(")")) {
    const auto length = header.integer();
    if (!length || layout.shape.size() == 32) return false;
    layout.shape.push_back(*length);
    if (!header.take(",")) return header.take(")");
  }
  return true;
}

bool read_entry(Header& header, Layout& layout) {
  const auto key = header.text();
  if (!key || !header.take(":")) return false;
  if (*key == "descr" && !layout.type) return (layout.type = header.text()).has_value();
  if (*key == "fortran_order" && !layout.by_columns) {
    if (header.take("True")) layout.by_columns = true;
    if (!layout.by_columns && header.take("False")) layout.by_columns = false;
    return layout.by_columns.has_value();
  }
  return *key == "shape" && read_shape(header, layout);
}

std::optional<Layout> read_layout(std::string_view text) {
  Header header{text};
  Layout layout;
  if (!header.take("{")) return std::nullopt;
  while (!header.take("}")) {
    if (!read_entry(header, layout)) return std::nullopt;
    if (header.take(",")) continue;
    if (!header.take("}")) return std::nullopt;
    break;
  }
  header.skip_blanks();
  if (!header.rest.empty() || !layout.type || !layout.by_columns || !layout.has_shape) {
    return std::nullopt;
  }
  return layout;
}

template <class T>
double number_at(const char* bytes, bool swapped) {
  char local[sizeof(T)];
  std::memcpy(local, bytes, sizeof(T));
  if (swapped) std::reverse(local, local + sizeof(T));
  T value;
  std::memcpy(&value, local, sizeof(T));
  return static_cast<double>(value);
}

struct NumberType {
  std::string_view name;
  std::size_t bytes;
  double (*at)(const char*, bool);
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

Result<GridFile> read_numbers(const Layout& layout, std::string_view data) {
  const NumberType* type = type_of(*layout.type);
  if (type == nullptr) {
    return wrong(fmt::format("holds numbers of type {}, accepted are f4, f8, i1 to i8, u1 to u8",
                             shown(*layout.type)));
  }
  if (layout.shape.size() != 2) {
    return wrong(
        fmt::format("has {} dimensions, accepted are two: rows from north to south, "
                    "columns from west to east",
                    layout.shape.size()));
  }
  if (Status size = check_grid_size(layout.shape[0], layout.shape[1]); !size) return size.error();
  GridFile grid;
  grid.rows = static_cast<int>(layout.shape[0]);
  grid.columns = static_cast<int>(layout.shape[1]);
  const std::size_t count = std::size_t(grid.rows) * grid.columns;
  if (data.size() != count * type->bytes) {
    return wrong(
        fmt::format("holds {} bytes of numbers where {} x {} of them take {}; it is cut "
                    "off or holds more than one array",
                    data.size(), grid.rows, grid.columns, count * type->bytes));
  }
  const bool swapped = (*layout.type)[0] == '>';
  grid.values.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = *layout.by_columns ? i % grid.columns * grid.rows + i / grid.columns : i;
    grid.values[i] = type->at(data.data() + at * type->bytes, swapped);
  }
  return grid;
}

}  // namespace

Result<GridFile> parse_npy_grid(std::string_view bytes) {
  if (bytes.size() < 12 || !bytes.starts_with("\x93NUMPY")) {
    return wrong("is no NPY file: it does not begin like one");
  }
  const auto byte = [&](std::size_t i) {
    return std::size_t(static_cast<unsigned char>(bytes[i]));
  };
  const std::size_t version = byte(6);
  if (version < 1 || version > 3) {
    return wrong(fmt::format("is of NPY version {}, accepted are 1 to 3", version));
  }
  const std::size_t start = version == 1 ? 10 : 12;
  const std::size_t length =
      byte(8) | byte(9) << 8 | (version == 1 ? 0 : byte(10) << 16 | byte(11) << 24);
  if (length > kMaxHeaderBytes || length > bytes.size() - start) {
    return wrong("is no NPY file: its header is cut off or too long");
  }
  const auto layout = read_layout(bytes.substr(start, length));
  if (!layout) return wrong("is no NPY file of plain numbers: its header is not understood");
  return read_numbers(*layout, bytes.substr(start + length));
}

}  // namespace ensonify
