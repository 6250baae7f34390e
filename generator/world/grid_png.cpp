#include <fmt/format.h>

#include "formats/png.h"
#include "world/grid_file.h"

namespace ensonify {

Result<GridFile> parse_png_grid(std::string_view bytes) {
  // The size is checked before memory is allocated for the pixels.
  if (const auto header = parse_png_header(bytes)) {
    if (header->color_type != 0 || header->bit_depth < 8) {
      return Error{ErrorKind::usage,
                   fmt::format("is a PNG file of {} bits and color type {}; expected a grayscale "
                               "image (color type 0) of 8 or 16 bits",
                               header->bit_depth, header->color_type)};
    }
    if (Status size = check_grid_size(header->height, header->width); !size) return size.error();
  }
  const auto image = parse_grey_png(bytes);
  if (!image) return image.error();
  GridFile grid;
  grid.rows = static_cast<int>(image->rows);
  grid.columns = static_cast<int>(image->columns);
  grid.white = image->grey16.empty() ? 255 : 65535;
  grid.values.assign(image->grey8.begin(), image->grey8.end());
  if (grid.values.empty()) grid.values.assign(image->grey16.begin(), image->grey16.end());
  return grid;
}

}  // namespace ensonify
