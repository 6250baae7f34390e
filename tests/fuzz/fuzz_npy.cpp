// NPY arrays of a data set. What the caller takes for the shape is told by the first two bytes.
#include <array>

#include "formats/npy.h"
#include "fuzz_file.h"

using namespace ensonify;

namespace {

constexpr std::array kTypes = {kNpyFloat32, kNpyComplex64, kNpyUint16, kNpyUint8};

// What the header tells, and others.
NpyShape shape_of(std::string_view bytes, unsigned choice) {
  const auto header = parse_npy_header(bytes);
  if (choice % 4 == 1) return {0};
  if (choice % 4 == 2) return {2, 3};
  if (choice % 4 == 3) return {std::uint64_t{1} << 62, 16};
  return header ? header->shape : NpyShape{1};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::string_view bytes = test::text_of(data + 2, size - 2);
  const auto path = test::fuzz_file("a.npy", bytes);
  const std::string_view type = kTypes[data[0] % kTypes.size()];
  const NpyShape shape = shape_of(bytes, data[1]);
  std::uint64_t row_bytes = npy_item_bytes(type).value_or(0);
  for (std::size_t i = 1; i < shape.size(); ++i) row_bytes *= shape[i];
  if (const auto array = read_npy(path, type, shape)) {
    test::promise(array->data().size() + array->offset == bytes.size());
    test::accepted();
  }
  if (const auto row = read_npy_row(path, type, shape, data[1] / 4u)) {
    test::promise(row->size() == row_bytes && row->size() <= bytes.size());
  }
  return 0;
}
