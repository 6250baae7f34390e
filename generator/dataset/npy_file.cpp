#include "dataset/npy_file.h"

#include <algorithm>
#include <fstream>
#include <utility>

#include "dataset/files.h"
#include "dataset/read_dataset.h"

namespace ensonify {
namespace {

// Holds every header that ensonify writes.
constexpr std::size_t kHeaderBytes = 4096;

}  // namespace

Result<NpyArray> read_npy(const std::filesystem::path& path, std::string_view descr,
                          const NpyShape& shape) {
  auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  const auto header = parse_npy_header(*bytes);
  if (!header || header->descr != descr || header->fortran_order) {
    return damaged(path, "is not an NPY file of the type that it should be");
  }
  const bool any_length = shape == NpyShape{0} && header->shape.size() == 1;
  if (!any_length && header->shape != shape) {
    return damaged(path, "is not of the shape that sequence.json tells");
  }
  // Divided, because a product of wrong numbers could come round to a right one.
  std::uint64_t rest = bytes->size() - header->data_offset;
  const std::uint64_t item = npy_item_bytes(descr).value_or(1);
  bool fits = rest % item == 0;
  rest /= item;
  for (const std::uint64_t n : header->shape) {
    fits = fits && (n == 0 ? rest == 0 : rest % n == 0);
    rest = n == 0 ? 1 : rest / n;
  }
  if (!fits || rest != 1) return damaged(path, "is not as long as its header tells");
  return NpyArray{header->shape, std::move(*bytes), static_cast<std::size_t>(header->data_offset)};
}

Result<std::string> read_npy_row(const std::filesystem::path& path, std::string_view descr,
                                 const NpyShape& shape, std::uint64_t row) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(kHeaderBytes, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  const auto header = parse_npy_header(bytes);
  if (!header || header->descr != descr || header->fortran_order || header->shape != shape ||
      shape.empty() || row >= shape[0] || header->data_offset > bytes.size()) {
    return damaged(path, "is not of the type and shape that sequence.json tells");
  }
  std::uint64_t size = npy_item_bytes(descr).value_or(0);
  for (std::size_t i = 1; i < shape.size(); ++i) size *= shape[i];
  file.clear();
  file.seekg(0, std::ios::end);
  const auto end = static_cast<std::uint64_t>(std::max<std::streamoff>(file.tellg(), 0));
  if (size == 0 || end < header->data_offset || (end - header->data_offset) / size <= row) {
    return damaged(path, "is cut short");
  }
  bytes.assign(size, '\0');
  file.seekg(static_cast<std::streamoff>(header->data_offset + row * size));
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (std::cmp_not_equal(file.gcount(), size)) return damaged(path, "is cut short");
  return bytes;
}

}  // namespace ensonify
