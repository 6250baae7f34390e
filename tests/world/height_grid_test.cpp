#include "world/terrain.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "catch.h"
#include "grid_texts.h"
#include "is_refused.h"
#include "temporary_folder.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

const std::vector<double> kSix = {1, -2, 3.5, 4, 5, -6.25};  // two rows of three

std::vector<double> heights(const std::filesystem::path& file) {
  const auto grid = load_height_grid(file, 1, 1, 0);
  INFO((grid.ok() ? "" : grid.error().message));
  REQUIRE(grid.ok());
  CHECK(grid->rows == 2);
  CHECK(grid->columns == 3);
  return grid->heights_m;
}

template <class T>
std::vector<T> as(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

template <class T>
std::vector<T> swapped(std::vector<T> values) {
  for (T& value : values) {
    char* bytes = reinterpret_cast<char*>(&value);
    std::reverse(bytes, bytes + sizeof(T));
  }
  return values;
}

std::string message_of(const TemporaryFolder& folder, const std::string& name,
                       const std::string& bytes) {
  const auto grid = load_height_grid(folder.write(name, bytes), 1, 1, 0);
  if (grid.ok()) return "";
  CHECK(grid.error().kind == ErrorKind::usage);
  CHECK(grid.error().message.find(name + ": ") != std::string::npos);
  return grid.error().message;
}

}  // namespace

// Protects what people bring: every type of number, both orders of bytes and of axes.
TEST_CASE("NPY of any number type and order gives the same heights") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& bytes) { return heights(folder.write("a.npy", bytes)); };
  CHECK(read(npy("<f8", 2, 3, kSix)) == kSix);
  CHECK(read(npy("<f4", 2, 3, as<float>(kSix))) == kSix);
  CHECK(read(npy("=f8", 2, 3, kSix)) == kSix);
  CHECK(read(npy(">f8", 2, 3, swapped(kSix))) == kSix);
  CHECK(read(npy(">f4", 2, 3, swapped(as<float>(kSix)))) == kSix);
  const std::vector<double> by_columns = {1, 4, -2, 5, 3.5, -6.25};
  CHECK(read(npy(npy_header("<f8", 2, 3, true), by_columns)) == kSix);
  const std::vector<double> whole = {1, 2, 3, 4, 250, 100};
  CHECK(read(npy("|u1", 2, 3, as<std::uint8_t>(whole))) == whole);
  CHECK(read(npy("<u2", 2, 3, as<std::uint16_t>(whole))) == whole);
  CHECK(read(npy("<i4", 2, 3, as<std::int32_t>(whole))) == whole);
  CHECK(read(npy(">u8", 2, 3, swapped(as<std::uint64_t>(whole)))) == whole);
  const std::vector<double> negative = {-1, -2, 3, 4, -128, 100};
  CHECK(read(npy("|i1", 2, 3, as<std::int8_t>(negative))) == negative);
  CHECK(read(npy("<i2", 2, 3, as<std::int16_t>(negative))) == negative);
  CHECK(read(npy("<i8", 2, 3, as<std::int64_t>(negative))) == negative);
  // As another writer might put it.
  CHECK(read(npy("{\"shape\":(2,3),\"descr\":\"<f8\",\"fortran_order\":False}   \n", kSix)) ==
        kSix);
}

// Protects the choice of file format from mattering.
TEST_CASE("PNG and ESRI ASCII hold the same heights as NPY") {
  const TemporaryFolder folder;
  const std::vector<std::uint16_t> deep = {0, 1, 256, 65535, 40000, 777};
  const std::vector<double> wanted = {0, 1, 256, 65535, 40000, 777};
  CHECK(heights(folder.write("a.npy", npy("<u2", 2, 3, deep))) == wanted);
  CHECK(heights(folder.write("a.PNG", png(deep.data(), 2, 3, PNG_FORMAT_LINEAR_Y))) == wanted);
  const std::vector<std::uint8_t> flat = {0, 1, 2, 128, 254, 255};
  CHECK(heights(folder.write("b.png", png(flat.data(), 2, 3, PNG_FORMAT_GRAY))) ==
        std::vector<double>{0, 1, 2, 128, 254, 255});
  const auto file = folder.write("a.asc",
                                 "NCOLS 3\r\nnrows 2\nxllcorner 500000.5\nyllcorner 4.5e6\n"
                                 "cellsize 0.5\n0 1 256\n65535 40000\n 777\n");
  CHECK(heights(file) == wanted);
  CHECK(load_height_grid(file, 7, 1, 0)->cell_m == 0.5);
}

// Protects where things lie: columns run east, the first row is the northern one.
TEST_CASE("a plane given as NPY is that plane") {
  const TemporaryFolder folder;
  const auto plane = [](double x, double y) { return 0.25 * x - 0.125 * y; };
  std::vector<double> values;
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 9; ++column) {
      values.push_back((plane((column - 4) * 0.5, (2 - row) * 0.5) - 3) / 2);
    }
  }
  const auto grid = load_height_grid(folder.write("p.npy", npy("<f8", 5, 9, values)), 0.5, 2, 3);
  REQUIRE(grid.ok());
  CHECK(column_x_m(*grid, 8) == 2);
  CHECK(row_y_m(*grid, 0) == 1);
  for (int i = 0; i < 5 * 9; ++i) {
    const double x = column_x_m(*grid, i % 9), y = row_y_m(*grid, i / 9);
    CHECK(grid->heights_m[i] == Approx(plane(x, y)).margin(1e-12));
  }
}

TEST_CASE("NODATA and NaN are holes") {
  const TemporaryFolder folder;
  const std::string head = "ncols 2\nnrows 2\ncellsize 1\n";
  const auto hole = [&](const std::string& name, const std::string& bytes) {
    const auto grid = load_height_grid(folder.write(name, bytes), 1, 2, 1);
    REQUIRE(grid.ok());
    CHECK(grid->heights_m[0] == 3);
    return std::isnan(grid->heights_m[1]);
  };
  CHECK(hole("a.asc", head + "NODATA_value -5\n1 -5 1 1"));
  CHECK(hole("b.asc", head + "1 -9999 1 1"));
  CHECK_FALSE(hole("c.asc", head + "NODATA_value -5\n1 -9999 1 1"));
  CHECK(hole("a.npy", npy("<f4", 2, 2, std::vector<float>{1, std::nanf(""), 1, 1})));
  CHECK(message_of(folder, "d.asc", head + "-9999 -9999 -9999 -9999").find("no height") !=
        std::string::npos);
}

// Protects the process and the user: whatever is wrong is told with the file's name, and a header
// alone takes no memory.
TEST_CASE("broken NPY files are refused") {
  const TemporaryFolder folder;
  const std::string whole = npy("<f8", 2, 3, kSix);
  const auto refuse = [&](const std::string& bytes, const std::string& why) {
    const std::string message = message_of(folder, "x.npy", bytes);
    INFO(message);
    CHECK(message.find(why) != std::string::npos);
  };
  refuse("", "not an NPY file");
  refuse("PK\3\4 and so on and so on", "not an NPY file");
  for (std::size_t size = 1; size < whole.size(); size += 7) refuse(whole.substr(0, size), "");
  refuse(whole.substr(0, whole.size() - 1), "holds 47 bytes of numbers, but 2 x 3 of them take 48");
  refuse(whole + "x", "holds 49 bytes");
  std::string version = whole;
  version[6] = '\7';
  refuse(version, "version 7");
  refuse(npy("<c16", 2, 3, kSix), "`<c16`");
  refuse(npy("|f8", 2, 3, kSix), "`|f8`");
  refuse(npy("|O", 2, 3, kSix), "`|O`");
  refuse(npy("<f8", 1, 6, kSix), "at least 2 rows of 2");
  refuse(npy("<f8", 2, 0, kSix), "at least 2 rows of 2");
  refuse(npy("<f8", 10000, 10000, kSix), "64000000");
  refuse(npy("<f8", 2000000000, 2000000000, kSix), "64000000");
  const std::string rest = "'descr': '<f8', 'fortran_order': False";
  refuse(npy("{" + rest + ", 'shape': (6,), }\n", kSix), "has 1 dimensions");
  refuse(npy("{" + rest + ", 'shape': (2, 3, 1), }\n", kSix), "has 3 dimensions");
  for (const std::string& header :
       {rest, "{" + rest + "}", "{" + rest + ", 'shape': (-2, 3)}",
        "{" + rest + ", 'shape': (2 3)}", "{" + rest + ", 'shape': (2, 99999999999999999999)}",
        "{" + rest + ", 'shape': 6}", "{" + rest + ", 'shape': (2, 3), 'more': 1}",
        "{" + rest + ", 'shape': (2, 3)} x", "{" + rest + ", " + rest + ", 'shape': (2, 3)}",
        std::string("{'descr"),
        std::string("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (2, 3)}")}) {
    INFO(header);
    refuse(npy(header + "\n", kSix), "its header cannot be read");
  }
  refuse(npy("<f8", 2, 2, std::vector<double>{1, 2, INFINITY, 4}), "row 1, column 0 is inf");
  refuse(npy("<f8", 2, 2, std::vector<double>{1, 2, 3, -2e7}), "row 1, column 1");
}

TEST_CASE("broken PNG files are refused") {
  const TemporaryFolder folder;
  const std::vector<std::uint8_t> pixels(3 * 64 * 64, 100);
  const std::string whole = png(pixels.data(), 64, 64, PNG_FORMAT_GRAY);
  REQUIRE(message_of(folder, "x.png", whole).empty());
  const auto refuse = [&](const std::string& bytes, const std::string& why) {
    const std::string message = message_of(folder, "x.png", bytes);
    INFO(message);
    CHECK(message.find(why) != std::string::npos);
  };
  refuse("", "cut off");
  refuse("not a picture at all", "not a readable PNG file");
  for (std::size_t size = 1; size < whole.size(); size += 5) {
    refuse(whole.substr(0, size), "not a readable PNG file");
  }
  std::string damaged = whole;
  damaged[whole.size() - 20] = static_cast<char>(damaged[whole.size() - 20] ^ 16);
  refuse(damaged, "not a readable PNG file");
  refuse(png(pixels.data(), 64, 64, PNG_FORMAT_RGB), "color type 2");
  refuse(png(pixels.data(), 1, 64, PNG_FORMAT_GRAY), "at least 2 rows of 2");
}

TEST_CASE("broken ESRI ASCII grids are refused with their line") {
  const TemporaryFolder folder;
  const std::string head = "ncols 2\nnrows 2\ncellsize 1\n";
  const auto refuse = [&](const std::string& text, const std::string& why) {
    const std::string message = message_of(folder, "x.asc", text);
    INFO(text << "\n" << message);
    CHECK(message.find(why) != std::string::npos);
  };
  REQUIRE(message_of(folder, "x.asc", head + "1 2\n3 4\n").empty());
  refuse("", "ncols is missing");
  refuse("1 2\n3 4\n", "ncols is missing");
  refuse("ncols 2\nnrows 2\n1 2 3 4", "cellsize is missing");
  refuse(head + "dx 1\n1 2 3 4", "line 4: unknown key `dx`");
  refuse(head + "nrows 2\n1 2 3 4", "line 4: nrows is given twice");
  refuse("ncols two\n", "line 1: ncols is not followed by a number");
  refuse(head + "1 2\n3 x\n", "line 5: found `x` for height 4 of 4");
  refuse(head + "1 2\n3,5 4\n", "line 5: found `3,5`");
  refuse(head + "1 2\n3    ", "found nothing for height 4 of 4");
  refuse(head + "1 2\n3 4\n5", "line 6: holds more than 2 rows of 2");
  refuse(head + "1 2\n3 inf\n", "row 1, column 1 is inf");
  refuse("ncols 2.5\nnrows 2\ncellsize 1\n1 2 3 4", "ncols is 2.5");
  refuse("ncols 2\nnrows 1e300\ncellsize 1\n1 2 3 4", "nrows is 1e+300");
  refuse("ncols 2\nnrows nan\ncellsize 1\n1 2 3 4", "nrows is nan");
  refuse("ncols 9000\nnrows 9000\ncellsize 1\n1 2 3 4", "64000000");
  refuse("ncols 7000\nnrows 7000\ncellsize 1\n1 2 3 4", "too short");
  refuse("ncols 2\nnrows 2\ncellsize 0\n1 2 3 4", "cellsize is 0");
  refuse("ncols 3\nnrows 2\ncellsize 1e7\n1 2 3 4 5 6", "its longer side");
}

TEST_CASE("a grid that is not there is an error of reading") {
  const TemporaryFolder folder;
  const auto grid = load_height_grid(folder.path() / "none.npy", 1, 1, 0);
  CHECK(is_refused(grid, "none.npy: cannot be read", ErrorKind::io));
}
