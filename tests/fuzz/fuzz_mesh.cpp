// Our own part of reading meshes: whether a file is all there, told by its first byte which format,
// and what the importer hands over.
#include <array>
#include <cstring>

#include "fuzz_file.h"
#include "world/import/import.h"
#include "world/import/wire.h"

using namespace ensonify;

namespace {

void read_wire(std::string_view bytes, bool density) {
  const WireInput in{[&bytes](void* to, std::size_t wanted) {
                       if (wanted > bytes.size()) return false;
                       if (wanted > 0) std::memcpy(to, bytes.data(), wanted);
                       bytes.remove_prefix(wanted);
                       return true;
                     },
                     std::uint64_t{1} << 28};
  if (density) {
    const auto grid = read_density(in);
    if (!grid) return;
    density_at(*grid, {1, 2, 3});
    test::accepted();
    return;
  }
  auto mesh = read_mesh(in);
  if (!mesh) return;
  drop_faces_without_area(*mesh);
  test::accepted();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes = test::text_of(data + 1, size - 1);
  constexpr std::array kNames = {"a.ply", "a.stl", "a.gltf"};
  const unsigned choice = data[0] % 5;
  if (choice >= kNames.size()) {
    read_wire(bytes, choice == 3);
  } else if (check_mesh_text(kNames[choice], bytes)) {
    test::accepted();
  }
  return 0;
}
