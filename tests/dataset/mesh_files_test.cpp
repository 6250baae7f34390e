#include "dataset/geometry_files.h"

#include "catch.h"
#include "formats/bytes.h"
#include "sample.h"

using namespace ensonify;

namespace {

std::string ply(int vertices, int faces) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment meters in the world frame, z up\n"
      "comment instance 1 class 1 end_header end_header\nelement vertex " +
      std::to_string(vertices) +
      "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
      std::to_string(faces) +
      "\nproperty list uchar int vertex_indices\nproperty ushort instance\nproperty uchar class\n"
      "end_header\n";
  return bytes + std::string(static_cast<std::size_t>(24 * vertices + 16 * faces), '\n');
}

void put_chunk(std::string& bytes, const char* kind, const std::string& content) {
  put_value(bytes, static_cast<std::uint32_t>(content.size()));
  bytes.append(kind, 4);
  bytes += content;
}

std::string glb() {
  std::string bytes = "glTF";
  put_value(bytes, std::uint32_t{2});
  put_value(bytes, std::uint32_t{12 + 8 + 4 + 8 + 12});
  put_chunk(bytes, "JSON", "{}  ");
  put_chunk(bytes, "BIN\0", std::string(12, 'x'));
  return bytes;
}

template <class Fault>
std::string fault_of(Fault fault, const std::string& bytes) {
  const sample::TemporaryFolder folder;
  sample::write(folder.path() / "file", bytes);
  return fault(folder.path() / "file");
}

}  // namespace

// Protects verify: files cut short, or with headers that promise something else, are found.
TEST_CASE("a mesh in PLY that is not whole is found") {
  std::string bytes = ply(4, 2);
  CHECK(fault_of(mesh_ply_fault, bytes).empty());
  CHECK(fault_of(mesh_ply_fault, ply(0, 0)).empty());
  SECTION("cut short") { bytes.pop_back(); }
  SECTION("longer") { bytes += '\0'; }
  SECTION("more vertices") { bytes.replace(bytes.find("vertex 4"), 8, "vertex 5"); }
  SECTION("more faces than bytes") {
    bytes.replace(bytes.find("face 2"), 6, "face 18446744073709551615");
  }
  SECTION("another type") { bytes.replace(bytes.find("uchar class"), 11, "float class"); }
  SECTION("no header") { bytes.resize(bytes.find("end_header\n")); }
  SECTION("empty") { bytes.clear(); }
  CHECK_FALSE(fault_of(mesh_ply_fault, bytes).empty());
}

TEST_CASE("a binary glTF file that is not whole is found") {
  std::string bytes = glb();
  CHECK(fault_of(glb_fault, bytes).empty());
  SECTION("cut short") { bytes.pop_back(); }
  SECTION("longer") { bytes += '\0'; }
  SECTION("another version") { bytes[4] = 1; }
  SECTION("another magic number") { bytes[0] = 'G'; }
  SECTION("another chunk") { bytes.replace(bytes.find("BIN"), 3, "BUN"); }
  SECTION("a longer chunk") { bytes[12] = 5; }
  SECTION("a chunk beyond the file") { bytes[15] = 127; }
  SECTION("empty") { bytes.clear(); }
  CHECK_FALSE(fault_of(glb_fault, bytes).empty());
}
