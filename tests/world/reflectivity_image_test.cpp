// Images on meshes: what the factor at a place is, which files are accepted, and which coordinates
// the formats of meshes have.
#include "world/reflectivity_image.h"
#include "scenario/scenario.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "catch.h"
#include "formats/png.h"
#include "grid_texts.h"
#include "is_refused.h"
#include "scenes.h"
#include "temporary_folder.h"
#include "world/world.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

ReflectivityImage image_of(const std::string& bytes) {
  auto image = parse_reflectivity_image(bytes);
  if (!image) FAIL(image.error().message);
  return std::move(*image);
}

// Each row comes in seven passes.
std::string interlaced_png(std::vector<std::uint8_t> rgb, unsigned rows, unsigned columns) {
  std::string bytes;
  png_structp writer = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(writer);
  const auto append = [](png_structp to, png_bytep data, std::size_t size) {
    static_cast<std::string*>(png_get_io_ptr(to))->append(data, data + size);
  };
  png_set_write_fn(writer, &bytes, append, nullptr);
  png_set_IHDR(writer, info, columns, rows, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_ADAM7,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  std::vector<png_bytep> lines;
  for (unsigned row = 0; row < rows; ++row) lines.push_back(rgb.data() + 3 * row * columns);
  png_set_rows(writer, info, lines.data());
  png_write_png(writer, info, PNG_TRANSFORM_IDENTITY, nullptr);
  png_destroy_write_struct(&writer, &info);
  return bytes;
}

template <class Pixel>
std::string grey_png(std::vector<Pixel> pixels, int rows, int columns) {
  return *encode_png(pixels, rows, columns);
}

std::string base64(const std::string& bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  REQUIRE(bytes.size() % 3 == 0);
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned word = 0;
    for (int k = 0; k < 3; ++k) word = word << 8 | static_cast<unsigned char>(bytes[i + k]);
    for (int shift = 18; shift >= 0; shift -= 6) text += kDigits[word >> shift & 63];
  }
  return text;
}

// One triangle, y up as in the format: three corners, then their texture coordinates.
std::string textured_gltf() {
  const std::array<float, 15> numbers{0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 1, 1, 1, 0, 0};
  std::string bytes(sizeof numbers, '\0');
  std::memcpy(bytes.data(), numbers.data(), sizeof numbers);
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "mode": 4}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
"min": [0, 0, -1], "max": [1, 0, 0]},
{"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}],
"bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
"buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,)" +
         base64(bytes) + R"("}]})";
}

constexpr const char* kSheet =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 2 0\nvt 2 1\nvt 0 1\n"
    "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";

// The texture coordinates of the vertices at a place.
std::vector<std::array<float, 2>> uv_at(const Mesh& mesh, std::array<float, 3> place) {
  std::vector<std::array<float, 2>> found;
  REQUIRE(mesh.uv.size() == mesh.vertices.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (mesh.vertices[v] == place) found.push_back(mesh.uv[v]);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace

// 3 columns, 2 rows: pixel (row j, column i) is at u = (i + 1/2)/3, v = 1 - (j + 1/2)/2.
TEST_CASE("an image is bilinear between pixel centers, v up, and repeats") {
  const ReflectivityImage image =
      image_of(grey_png<std::uint8_t>({0, 51, 255, 102, 204, 153}, 2, 3));
  const double pixel[2][3] = {{0, 0.2, 1}, {0.4, 0.8, 0.6}};
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 3; ++column) {
      const double u = (column + 0.5) / 3, v = 1 - (row + 0.5) / 2;
      for (const double turns : {0.0, 1.0, -1.0, -7.0, 1e6}) {
        CHECK(image.at(u + turns, v) == Approx(pixel[row][column]).margin(1e-6));
        CHECK(image.at(u, v - turns) == Approx(pixel[row][column]).margin(1e-6));
      }
    }
  }
  CHECK(image.at(1.0 / 3, 0.75) == Approx(0.1));                     // between 0 and 0.2
  CHECK(image.at(0.5, 0.5) == Approx(0.5));                          // between 0.2 and 0.8
  CHECK(image.at(0.25, 0.625) == Approx(0.75 * 0.05 + 0.25 * 0.5));  // of four pixels
  // The last column meets the first one, and the lowest row the uppermost one.
  CHECK(image.at(0, 0.75) == Approx(0.5));
  CHECK(image.at(1, 0.25) == Approx(0.5));
  CHECK(image.at(1.0 / 6, 0) == Approx(0.2));
  CHECK(image.at(1.0 / 6, 1) == Approx(0.2));
}

TEST_CASE("gray and color of 8 and 16 bits give the mean over the highest value") {
  const ReflectivityImage deep = image_of(grey_png<std::uint16_t>({0, 65535, 13107}, 1, 3));
  CHECK(deep.rows == 1);
  CHECK(deep.columns == 3);
  CHECK(deep.factors == std::vector<float>{0, 1, 0.2f});
  const std::uint8_t rgb[] = {255, 0, 0, 255, 255, 255, 10, 20, 31};
  const ReflectivityImage color = image_of(png(rgb, 1, 3, PNG_FORMAT_RGB));
  CHECK(color.factors[0] == Approx(1 / 3.0));
  CHECK(color.factors[1] == 1);
  CHECK(color.factors[2] == Approx(61 / 765.0));
  // Transparency changes nothing.
  const std::uint8_t rgba[] = {255, 0, 0, 0, 255, 255, 255, 77};
  CHECK(image_of(png(rgba, 1, 2, PNG_FORMAT_RGBA)).factors[0] == Approx(1 / 3.0));
  const std::uint8_t ga[] = {51, 3, 255, 0};
  CHECK(image_of(png(ga, 1, 2, PNG_FORMAT_GA)).factors == std::vector<float>{0.2f, 1});
  std::vector<std::uint8_t> many;
  for (int i = 0; i < 3 * 11 * 13; ++i) many.push_back(static_cast<std::uint8_t>(7 * i));
  const ReflectivityImage interlaced = image_of(interlaced_png(many, 11, 13));
  CHECK(interlaced.factors == image_of(png(many.data(), 11, 13, PNG_FORMAT_RGB)).factors);
  CHECK(interlaced.factors.size() == 11 * 13);
  Palette palette{};
  palette[7] = {255, 255, 0};
  const std::string indexed = *encode_palette_png(std::vector<std::uint8_t>{7, 0}, 1, 2, palette);
  CHECK(image_of(indexed).factors[0] == Approx(2 / 3.0));
  CHECK(image_of(indexed).factors[1] == 0);
}

TEST_CASE("an image that cannot be one is refused with the reason") {
  const auto why = [](const std::string& bytes) {
    const auto image = parse_reflectivity_image(bytes);
    REQUIRE_FALSE(image.ok());
    CHECK(image.error().kind == ErrorKind::usage);
    return image.error().message;
  };
  const std::string good = grey_png<std::uint8_t>({1, 2, 3, 4}, 2, 2);
  CHECK(why("").find("is not a PNG file") != std::string::npos);
  CHECK(why("\xff\xd8\xff JPEG").find("is not a PNG file") != std::string::npos);
  CHECK(why(good.substr(0, good.size() - 20)).find("cut off") != std::string::npos);
  std::string damaged = good;
  damaged[45] = static_cast<char>(damaged[45] ^ 64);
  CHECK(why(damaged).find("is not a readable PNG file") != std::string::npos);
  std::string huge = good;
  huge[18] = '\x20';  // a width of 8194
  huge[22] = '\x20';
  CHECK(why(huge).find("has 8194 x 8194 pixels; expected at most 16777216") != std::string::npos);
  std::string hollow = good;
  hollow[18] = '\x08';  // 2050 x 2050, of 60 bytes
  hollow[22] = '\x08';
  CHECK(why(hollow).find("is not a readable PNG file") != std::string::npos);
  const TemporaryFolder folder;
  const auto missing = load_reflectivity_image(folder.path() / "none.png");
  CHECK(missing.error().kind == ErrorKind::io);
  CHECK(missing.error().message.find("none.png: cannot be read") != std::string::npos);
}

// Protects seams: corners of one place with two coordinates stay two vertices, smooth or not.
TEST_CASE("texture coordinates of OBJ and glTF have v up") {
  const TemporaryFolder folder;
  const auto sheet = folder.write("sheet.obj", kSheet);
  const std::string cut =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nvt 0 0\nvt 1 0\nvt 0 1\nvt 5 0\nvt 0 6\nvt 1 1\n"
      "f 1/1 2/2 3/3\nf 2/4 4/6 3/5\n";
  for (const Normals normals : {Normals::face, Normals::smooth}) {
    const auto mesh = load_mesh(sheet, {1, 1, 1}, normals, MeshReflectivity::texture);
    REQUIRE(mesh.ok());
    CHECK(mesh->reflectivity.empty());
    CHECK(uv_at(*mesh, {1, 1, 0}) == std::vector<std::array<float, 2>>{{2, 1}});
    CHECK(uv_at(*mesh, {0, 1, 0}) == std::vector<std::array<float, 2>>{{0, 1}});
    CHECK(load_mesh(sheet, {1, 1, 1}, normals)->uv.empty());
    const auto seam =
        load_mesh(folder.write("cut.obj", cut), {1, 1, 1}, normals, MeshReflectivity::texture);
    REQUIRE(seam.ok());
    CHECK(uv_at(*seam, {1, 0, 0}) == std::vector<std::array<float, 2>>{{1, 0}, {5, 0}});
    CHECK(uv_at(*seam, {0, 1, 0}) == std::vector<std::array<float, 2>>{{0, 1}, {0, 6}});
  }
  // glTF has v down: its (0, 1) is the lower left corner of the image.
  const auto gltf = load_mesh(folder.write("t.gltf", textured_gltf()), {1, 1, 1}, Normals::face,
                              MeshReflectivity::texture);
  if (!gltf) FAIL(gltf.error().message);
  CHECK(uv_at(*gltf, {0, 0, 0}) == std::vector<std::array<float, 2>>{{0, 0}});
  CHECK(uv_at(*gltf, {1, 0, 0}) == std::vector<std::array<float, 2>>{{1, 0}});
  CHECK(uv_at(*gltf, {0, 1, 0}) == std::vector<std::array<float, 2>>{{0, 1}});
}

TEST_CASE("meshes without texture coordinates are refused for an image") {
  const TemporaryFolder folder;
  const auto why = [&](const std::string& name, const std::string& text) {
    const auto mesh =
        load_mesh(folder.write(name, text), {1, 1, 1}, Normals::face, MeshReflectivity::texture);
    CHECK(is_refused(mesh, name, ErrorKind::usage));
    return mesh.error().message;
  };
  CHECK(why("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
            .find("has no texture coordinates, which reflectivity: texture needs") !=
        std::string::npos);
  std::string ply = "ply\nformat ascii 1.0\nelement vertex 3\n";
  for (const char* name : {"x", "y", "z", "s", "t"}) {
    ply += std::string("property float ") + name + "\n";
  }
  ply += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  CHECK(why("nan.ply", ply + "0 0 0 0 0\n1 0 0 1 nan\n0 1 0 0 1\n3 0 1 2\n")
            .find("are not finite numbers") != std::string::npos);
  const std::string half =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\no a\nf 1/1 2/2 3/3\n"
      "o b\nf 1 2 3\n";
  CHECK(why("half.obj", half).find("('b') has no texture coordinates") != std::string::npos);
}

TEST_CASE("faces without texture coordinates among others are told") {
  const TemporaryFolder folder;
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nvt 0 0\nvt 1 0\nvt 0 1\n";
  const auto warnings = [&](const std::string& name, const std::string& faces) {
    const auto mesh = load_mesh(folder.write(name, corners + faces), {1, 1, 1}, Normals::face,
                                MeshReflectivity::texture);
    REQUIRE(mesh.ok());
    return mesh->warnings;
  };
  CHECK(warnings("all.obj", "f 1/1 2/2 3/3\nf 2/2 3/3 4/2\n").empty());
  const auto some = warnings("some.obj", "f 1/1 2/2 3/3\nf 2 3 4\n");
  REQUIRE(some.size() == 1);
  CHECK(some[0].find("some.obj: 1 of 2 triangles have the texture coordinates (0, 0)") !=
        std::string::npos);
}

TEST_CASE("an image is read once, and meshes that differ in it are shared") {
  const TemporaryFolder folder;
  const auto file = folder.write("sheet.obj", kSheet);
  const auto a = folder.write("a.png", grey_png<std::uint8_t>({0, 255}, 1, 2));
  const auto b = folder.write("b.png", grey_png<std::uint8_t>({9}, 1, 1));
  const auto with = [&](const std::filesystem::path& image) {
    return MeshSpec{file, {1, 1, 1}, false, false, {}, image};
  };
  Scenario scenario = scenario_of_shapes({with(a), with(b), with(a), with({})});
  MeshLibrary library;
  const auto world = build_world(scenario, 0, &library);
  REQUIRE(world.ok());
  const auto shape = [](const World& of, int i) {
    return std::get<MeshShape>(of.objects[i].shape);
  };
  CHECK(shape(*world, 0).image == shape(*world, 2).image);
  CHECK(shape(*world, 0).image != shape(*world, 1).image);
  CHECK(shape(*world, 0).mesh == shape(*world, 1).mesh);
  CHECK(shape(*world, 0).mesh != shape(*world, 3).mesh);
  CHECK(shape(*world, 3).image == nullptr);
  CHECK(world->instances[0].image_reflectivity);
  CHECK_FALSE(world->instances[0].vertex_reflectivity);
  CHECK_FALSE(world->instances[3].image_reflectivity);
  const auto next = build_world(scenario, 1, &library);
  REQUIRE(next.ok());
  CHECK(shape(*next, 0).image == shape(*world, 0).image);

  scenario.objects[1].shape = with(folder.write("c.png", "no image"));
  scenario.objects[3].shape =
      MeshSpec{folder.write("e.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
               {1, 1, 1},
               false,
               false,
               {},
               a};
  const auto refused = build_world(scenario);
  REQUIRE_FALSE(refused.ok());
  const std::string message = refused.error().message;
  CHECK(message.starts_with("objects.1.shape.mesh.texture_file: "));
  CHECK(message.find("c.png: is not a PNG file") != std::string::npos);
  CHECK(message.find("\nobjects.3.shape.mesh.file: ") != std::string::npos);
}
