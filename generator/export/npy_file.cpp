#include "export/npy_file.h"

#include <utility>

#include "dataset/files.h"
#include "dataset/read_dataset.h"

namespace ensonify {

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

}  // namespace ensonify
