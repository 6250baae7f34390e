// The module libensonify_raster.so: drawings as pixels, by cairo.
#include <cairo.h>

#include <cstring>
#include <memory>

#include "figure/drawing.h"

namespace ensonify {
namespace {

struct CairoFreed {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* context) const { cairo_destroy(context); }
};
using Surface = std::unique_ptr<cairo_surface_t, CairoFreed>;
using Context = std::unique_ptr<cairo_t, CairoFreed>;

Error failed(cairo_status_t status) {
  const bool memory = status == CAIRO_STATUS_NO_MEMORY || status == CAIRO_STATUS_INVALID_SIZE;
  return {memory ? ErrorKind::device : ErrorKind::bug,
          std::string("drawing a figure: ") + cairo_status_to_string(status)};
}

Surface surface_of(const RgbImage& image) {
  Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height));
  if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS) return surface;
  unsigned char* data = cairo_image_surface_get_data(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  const std::uint8_t* from = image.rgb.data();
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x, from += 3) {
      const std::uint32_t pixel =
          std::uint32_t{from[0]} << 16 | std::uint32_t{from[1]} << 8 | std::uint32_t{from[2]};
      std::memcpy(data + std::ptrdiff_t{y} * stride + 4 * x, &pixel, sizeof pixel);
    }
  }
  cairo_surface_mark_dirty(surface.get());
  return surface;
}

RgbImage image_of(cairo_surface_t* surface, int width, int height) {
  RgbImage image;
  image.width = width;
  image.height = height;
  image.rgb.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::uint8_t* to = image.rgb.data();
  cairo_surface_flush(surface);
  const unsigned char* data = cairo_image_surface_get_data(surface);
  const int stride = cairo_image_surface_get_stride(surface);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::uint32_t pixel = 0;
      std::memcpy(&pixel, data + std::ptrdiff_t{y} * stride + 4 * x, sizeof pixel);
      for (const int bits : {16, 8, 0}) *to++ = static_cast<std::uint8_t>(pixel >> bits);
    }
  }
  return image;
}

class Painter {
 public:
  explicit Painter(cairo_t* context) : c_(context) {}

  void operator()(const DrawnBox& box) {
    set(box.fill, 1);
    cairo_rectangle(c_, box.x, box.y, box.width, box.height);
    cairo_fill(c_);
  }
  void operator()(const DrawnLine& line) {
    set(line.colour, line.opacity);
    cairo_set_line_width(c_, line.width);
    cairo_set_line_join(c_, CAIRO_LINE_JOIN_ROUND);
    cairo_new_path(c_);  // a text leaves a place behind
    for (const PlotPoint& point : line.points) cairo_line_to(c_, point.x, point.y);
    cairo_stroke(c_);
  }
  void operator()(const DrawnText& text) {
    set(text.colour, 1);
    cairo_select_font_face(c_, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(c_, text.size);
    cairo_text_extents_t extents;
    cairo_text_extents(c_, text.text.c_str(), &extents);
    const double share = text.anchor == Anchor::start ? 0 : text.anchor == Anchor::middle ? 0.5 : 1;
    cairo_save(c_);
    cairo_translate(c_, text.x, text.y);
    if (text.upwards) cairo_rotate(c_, -1.5707963267948966);
    cairo_move_to(c_, -share * extents.x_advance, 0);
    cairo_show_text(c_, text.text.c_str());
    cairo_restore(c_);
  }
  void operator()(const DrawnPicture& picture) {
    const Surface surface = surface_of(picture.image);
    cairo_set_source_surface(c_, surface.get(), picture.x, picture.y);
    cairo_pattern_set_filter(cairo_get_source(c_), CAIRO_FILTER_NEAREST);
    cairo_rectangle(c_, picture.x, picture.y, picture.image.width, picture.image.height);
    cairo_fill(c_);
  }

 private:
  void set(Rgb8 colour, double opacity) {
    cairo_set_source_rgba(c_, colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0,
                          opacity);
  }
  cairo_t* c_;
};

cairo_status_t append(void* to, const unsigned char* bytes, unsigned int count) {
  static_cast<std::string*>(to)->append(static_cast<const char*>(static_cast<const void*>(bytes)),
                                        count);
  return CAIRO_STATUS_SUCCESS;
}

Result<RgbImage> draw(const Drawing& drawing) {
  const Surface surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, drawing.width, drawing.height));
  const Context context(cairo_create(surface.get()));
  cairo_set_source_rgb(context.get(), 1, 1, 1);
  cairo_paint(context.get());
  Painter painter(context.get());
  for (const auto& item : drawing.items) std::visit(painter, item);
  if (const auto status = cairo_status(context.get()); status != CAIRO_STATUS_SUCCESS) {
    return failed(status);
  }
  return image_of(surface.get(), drawing.width, drawing.height);
}

Result<std::string> png(const RgbImage& image) {
  const Surface surface = surface_of(image);
  std::string bytes;
  const auto status = cairo_surface_write_to_png_stream(surface.get(), append, &bytes);
  if (status != CAIRO_STATUS_SUCCESS) return failed(status);
  return bytes;
}

constexpr RasterApi kApi{draw, png};

}  // namespace
}  // namespace ensonify

extern "C" const ensonify::RasterApi* ensonify_raster() { return &ensonify::kApi; }
