// Height grids: NPY, PNG and ESRI ASCII, by the first byte.
#include "fuzz_file.h"
#include "world/grid_file.h"

using namespace ensonify;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes = test::text_of(data + 1, size - 1);
  const auto grid = data[0] % 3 == 0   ? parse_npy_grid(bytes)
                    : data[0] % 3 == 1 ? parse_png_grid(bytes)
                                       : parse_asc_grid(bytes);
  if (grid) {
    test::accepted();
    test::promise(grid->rows >= 2 && grid->columns >= 2 &&
                  grid->values.size() == static_cast<std::size_t>(grid->rows) *
                                             static_cast<std::size_t>(grid->columns));
  }
  return 0;
}
