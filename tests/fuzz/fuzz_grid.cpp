// Height grids (NPY, PNG and ESRI ASCII) and images on meshes, by the first byte.
#include "fuzz_file.h"
#include "world/grid_file.h"
#include "world/reflectivity_image.h"

using namespace ensonify;

static void read_image(std::string_view bytes) {
  const auto image = parse_reflectivity_image(bytes);
  if (!image) return;
  test::accepted();
  test::promise(image->factors.size() ==
                static_cast<std::size_t>(image->rows) * static_cast<std::size_t>(image->columns));
  const float factor = image->at(-0.3, 1e9);
  test::promise(factor >= 0 && factor <= 1);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes = test::text_of(data + 1, size - 1);
  if (data[0] % 4 == 3) {
    read_image(bytes);
    return 0;
  }
  const auto grid = data[0] % 4 == 0   ? parse_npy_grid(bytes)
                    : data[0] % 4 == 1 ? parse_png_grid(bytes)
                                       : parse_asc_grid(bytes);
  if (grid) {
    test::accepted();
    test::promise(grid->rows >= 2 && grid->columns >= 2 &&
                  grid->values.size() == static_cast<std::size_t>(grid->rows) *
                                             static_cast<std::size_t>(grid->columns));
  }
  return 0;
}
