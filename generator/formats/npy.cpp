#include "formats/npy.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <fstream>
#include <utility>

#include "formats/bytes.h"
#include "formats/files.h"

namespace ensonify {

namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::size_t kPrefixBytes = 10;  // magic, version 1.0, two bytes of header length
constexpr std::size_t kAlignment = 64;
constexpr std::size_t kMostDimensions = 32;  // NumPy's own limit
constexpr std::size_t kMostHeaderBytes = 65536;
// Holds every header that is written here.
constexpr std::size_t kOwnHeaderBytes = 4096;

std::uint64_t element_count(const NpyShape& shape) {
  std::uint64_t count = 1;
  for (const std::uint64_t n : shape) count *= n;
  return count;
}

template <class T>
std::string encode(std::span<const T> data, std::string_view descr, const NpyShape& shape) {
  ENSONIFY_ASSERT(data.size() == element_count(shape));
  std::string bytes = npy_header(descr, shape);
  bytes.reserve(bytes.size() + data.size_bytes());
  bytes.append(static_cast<const char*>(static_cast<const void*>(data.data())), data.size_bytes());
  return bytes;
}

// What is left to read of a dictionary: {'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }
struct Literal {
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
  std::optional<std::string> up_to(char end) {
    const std::size_t at = rest.find(end);
    if (at == std::string_view::npos) return std::nullopt;
    std::string found(rest.substr(0, at));
    rest.remove_prefix(at + 1);
    return found;
  }
  std::optional<std::string> text() {
    if (take("'")) return up_to('\'');
    return take("\"") ? up_to('"') : std::nullopt;
  }
  // The text of a plain type is given with single quotes, the list of a structured one as it is.
  std::optional<std::string> type() {
    if (!take("[")) {
      const auto name = text();
      return name ? std::optional("'" + *name + "'") : std::nullopt;
    }
    const auto fields = up_to(']');
    return fields ? std::optional("[" + *fields + "]") : std::nullopt;
  }
  std::optional<bool> boolean() {
    if (take("True")) return true;
    return take("False") ? std::optional(false) : std::nullopt;
  }
  std::optional<NpyShape> shape() {
    NpyShape lengths;
    if (!take("(")) return std::nullopt;
    while (!take(")")) {
      skip_blanks();
      std::uint64_t n = 0;
      const auto [end, failed] = std::from_chars(rest.data(), rest.data() + rest.size(), n);
      if (failed != std::errc() || lengths.size() == kMostDimensions) return std::nullopt;
      rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
      lengths.push_back(n);
      if (take(",")) continue;
      if (!take(")")) return std::nullopt;
      break;
    }
    return lengths;
  }
};

std::optional<NpyHeader> parse_dictionary(std::string_view text) {
  Literal literal{text};
  std::optional<std::string> descr;
  std::optional<bool> by_columns;
  std::optional<NpyShape> shape;
  if (!literal.take("{")) return std::nullopt;
  while (!literal.take("}")) {
    const auto key = literal.text();
    if (!key || !literal.take(":")) return std::nullopt;
    bool understood = false;
    if (*key == "descr" && !descr) understood = (descr = literal.type()).has_value();
    if (*key == "fortran_order" && !by_columns) {
      understood = (by_columns = literal.boolean()).has_value();
    }
    if (*key == "shape" && !shape) understood = (shape = literal.shape()).has_value();
    if (!understood) return std::nullopt;
    if (literal.take(",")) continue;
    if (!literal.take("}")) return std::nullopt;
    break;
  }
  literal.skip_blanks();
  if (!literal.rest.empty() || !descr || !by_columns || !shape) return std::nullopt;
  return NpyHeader{*descr, *by_columns, *shape, 0};
}

// Bytes of '<f8'; none if it is not the type of a number.
std::optional<std::uint64_t> number_bytes(std::string_view type) {
  if (type.size() < 5 || !type.starts_with("'<") || !type.ends_with("'")) return std::nullopt;
  if (std::string_view("iufc").find(type[2]) == std::string_view::npos) return std::nullopt;
  std::uint64_t bytes = 0;
  const char* const end = type.data() + type.size() - 1;
  const auto [stop, error] = std::from_chars(type.data() + 3, end, bytes);
  if (error != std::errc{} || stop != end || bytes > 16) return std::nullopt;
  return bytes;
}

// Bytes of an element with fields: [('x', '<f8'), ('via', '<u2', (3,))]. None if a field is
// another.
std::optional<std::uint64_t> structure_bytes(std::string_view descr) {
  if (!descr.starts_with("[('")) return std::nullopt;
  std::uint64_t sum = 0;
  for (std::size_t at = 1; at != std::string_view::npos; at = descr.find("('", at + 1)) {
    const std::size_t type = std::min(descr.find(", ", at), descr.size() - 2) + 2;
    const std::size_t end = std::min(descr.find('\'', type + 1), descr.size() - 1) + 1;
    const auto bytes = number_bytes(descr.substr(type, end - type));
    if (!bytes) return std::nullopt;
    std::uint64_t count = 1;
    const std::string_view rest = descr.substr(end);
    if (rest.starts_with(", (")) {
      std::from_chars(rest.data() + 3, rest.data() + rest.size(), count);
      if (count > 256) return std::nullopt;
    }
    sum += *bytes * count;
  }
  return sum;
}

bool is_of(const Result<NpyHeader>& header, std::string_view descr) {
  return header && header->descr == descr && !header->fortran_order;
}

}  // namespace

std::string npy_header(std::string_view descr, const NpyShape& shape) {
  // Python writes a one-element tuple with a trailing comma.
  const std::string tuple =
      fmt::format("({}{})", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
  std::string dictionary =
      fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': {}, }}", descr, tuple);
  const std::size_t whole = kPrefixBytes + dictionary.size() + 1;
  dictionary.append((kAlignment - whole % kAlignment) % kAlignment, ' ');
  dictionary += '\n';
  ENSONIFY_ASSERT(dictionary.size() < 65536);

  std::string header(kMagic);
  header.append("\x01\x00", 2);
  put_value(header, static_cast<std::uint16_t>(dictionary.size()));
  return header + dictionary;
}

std::string encode_npy(std::span<const std::int32_t> data, const NpyShape& shape) {
  return encode(data, kNpyInt32, shape);
}
std::string encode_npy(std::span<const float> data, const NpyShape& shape) {
  return encode(data, kNpyFloat32, shape);
}
std::string encode_npy(std::span<const double> data, const NpyShape& shape) {
  return encode(data, kNpyFloat64, shape);
}
std::string encode_npy(std::span<const std::complex<float>> data, const NpyShape& shape) {
  return encode(data, kNpyComplex64, shape);
}

Result<NpyHeader> parse_npy_header(std::string_view bytes) {
  const auto wrong = [](const std::string& why) { return Error{ErrorKind::usage, why}; };
  if (bytes.size() < 12 || !bytes.starts_with(kMagic)) {
    return wrong("is not an NPY file: it does not begin like one");
  }
  const int version = static_cast<unsigned char>(bytes[kMagic.size()]);
  if (version < 1 || version > 3) {
    return wrong(fmt::format("has NPY version {}; expected 1 to 3", version));
  }
  const std::size_t start = version == 1 ? kPrefixBytes : 12;
  const std::size_t length =
      version == 1 ? value_at<std::uint16_t>(bytes, 8) : value_at<std::uint32_t>(bytes, 8);
  if (length > kMostHeaderBytes || length > bytes.size() - start) {
    return wrong("is not an NPY file: its header is cut off or too long");
  }
  auto header = parse_dictionary(bytes.substr(start, length));
  if (!header) return wrong("is not an NPY file of plain numbers: its header cannot be read");
  header->data_offset = start + length;
  return *std::move(header);
}

std::optional<std::uint64_t> npy_item_bytes(std::string_view descr) {
  if (descr == kNpyUint8) return 1;
  if (descr == kNpyUint16) return 2;
  if (descr == kNpyInt32) return 4;
  if (descr == kNpyFloat16) return 2;
  if (descr == kNpyFloat32) return 4;
  if (descr == kNpyFloat64) return 8;
  if (descr == kNpyComplex64) return 8;
  if (descr == kNpyComplex128) return 16;
  return structure_bytes(descr);
}

Result<NpyArray> read_npy(const std::filesystem::path& path, std::string_view descr,
                          const NpyShape& shape) {
  auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  const auto header = parse_npy_header(*bytes);
  if (!is_of(header, descr)) {
    return damaged(path, "is not an NPY file of the expected type");
  }
  const bool any_length = shape == NpyShape{0} && header->shape.size() == 1;
  if (!any_length && header->shape != shape) {
    return damaged(path, "does not have the shape given in sequence.json");
  }
  // Division, because the product of wrong numbers could overflow to the right one.
  std::uint64_t rest = bytes->size() - header->data_offset;
  const std::uint64_t item = npy_item_bytes(descr).value_or(1);
  bool fits = rest % item == 0;
  rest /= item;
  for (const std::uint64_t n : header->shape) {
    fits = fits && (n == 0 ? rest == 0 : rest % n == 0);
    rest = n == 0 ? 1 : rest / n;
  }
  if (!fits || rest != 1) return damaged(path, "does not have the length that its header gives");
  return NpyArray{header->shape, std::move(*bytes), static_cast<std::size_t>(header->data_offset)};
}

Result<std::string> read_npy_row(const std::filesystem::path& path, std::string_view descr,
                                 const NpyShape& shape, std::uint64_t row) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(kOwnHeaderBytes, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  const auto header = parse_npy_header(bytes);
  if (!is_of(header, descr) || header->shape != shape || shape.empty() || row >= shape[0]) {
    return damaged(path, "does not have the type and shape given in sequence.json");
  }
  std::uint64_t size = npy_item_bytes(descr).value_or(0);
  for (std::size_t i = 1; i < shape.size(); ++i) size *= shape[i];
  file.clear();
  file.seekg(0, std::ios::end);
  const auto end = static_cast<std::uint64_t>(std::max<std::streamoff>(file.tellg(), 0));
  if (size == 0 || end < header->data_offset || (end - header->data_offset) / size <= row) {
    return damaged(path, "is cut off");
  }
  bytes.assign(size, '\0');
  file.seekg(static_cast<std::streamoff>(header->data_offset + row * size));
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (std::cmp_not_equal(file.gcount(), size)) return damaged(path, "is cut off");
  return bytes;
}

}  // namespace ensonify
