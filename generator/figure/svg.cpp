// Drawings as SVG 1.1.
#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "figure/drawing.h"
#include "formats/bytes.h"

namespace ensonify {
namespace {

constexpr const char* kAnchors[] = {"start", "middle", "end"};

std::string hex(Rgb8 c) { return fmt::format("#{:02x}{:02x}{:02x}", c.red, c.green, c.blue); }

// Hundredths of a pixel, without trailing zeros.
std::string number(double value) {
  const double rounded = std::round(value * 100) / 100;
  return fmt::format("{}", rounded == 0 ? 0.0 : rounded);
}

// Names come from untrusted files.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '"') {
      out += "&quot;";
    } else if (byte < 0x20 && c != '\t' && c != '\n' && c != '\r') {
      out += "\xef\xbf\xbd";
    } else {
      out += c;
    }
  }
  // U+FFFE and U+FFFF are characters that XML does not allow either.
  for (const char* bad : {"\xef\xbf\xbe", "\xef\xbf\xbf"}) {
    for (auto at = out.find(bad); at != std::string::npos; at = out.find(bad, at)) {
      out.replace(at, 3, "\xef\xbf\xbd");
    }
  }
  return out;
}

class Writer {
 public:
  explicit Writer(std::string& out) : out_(out) {}

  Status operator()(const DrawnBox& box) {
    out_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>\n",
                        number(box.x), number(box.y), number(box.width), number(box.height),
                        hex(box.fill));
    return {};
  }
  Status operator()(const DrawnLine& line) {
    std::string points;
    for (const PlotPoint& point : line.points) {
      points += fmt::format("{}{},{}", points.empty() ? "" : " ", number(point.x), number(point.y));
    }
    out_ += fmt::format(
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"{} "
        "stroke-linejoin=\"round\"/>\n",
        points, hex(line.colour), number(line.width),
        line.opacity < 1 ? fmt::format(" stroke-opacity=\"{}\"", number(line.opacity)) : "");
    return {};
  }
  Status operator()(const DrawnText& text) {
    const std::string turn = text.upwards ? fmt::format(" transform=\"rotate(-90 {} {})\"",
                                                        number(text.x), number(text.y))
                                          : "";
    out_ += fmt::format(
        "<text x=\"{}\" y=\"{}\" font-size=\"{}\" text-anchor=\"{}\" fill=\"{}\"{}>{}</text>\n",
        number(text.x), number(text.y), number(text.size),
        kAnchors[static_cast<std::size_t>(text.anchor)], hex(text.colour), turn,
        escaped(text.text));
    return {};
  }
  Status operator()(const DrawnPicture& picture) {
    const auto png = encode_png(picture.image);
    if (!png) return png.error();
    out_ += fmt::format(
        "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" "
        "xlink:href=\"data:image/png;base64,{}\"/>\n",
        picture.x, picture.y, picture.image.width, picture.image.height, base64(*png));
    return {};
  }

 private:
  std::string& out_;
};

}  // namespace

Result<std::string> encode_svg(const Drawing& drawing) {
  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" "
      "width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"'DejaVu Sans', Verdana, Helvetica, Arial, sans-serif\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n",
      drawing.width, drawing.height);
  Writer writer(out);
  for (const auto& item : drawing.items) {
    if (const Status written = std::visit(writer, item); !written) return written.error();
  }
  return out + "</svg>\n";
}

}  // namespace ensonify
