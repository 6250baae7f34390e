// Protects: no foreign file, and no library that reads one, can take the program down with it.
#include "world/foreign_file.h"

#include <cstring>
#include <fstream>
#include <limits>

#include "catch.h"
#include "is_refused.h"
#include "temporary_folder.h"
#include "world/density.h"
#include "world/import/import.h"
#include "world/mesh.h"
#include "write_vdb.h"

namespace ensonify {
namespace {

using test::TemporaryFolder;

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

// What an importer writes, as bytes.
template <class T>
std::string written(bool (*write)(WireOutput, const T&), const T& value) {
  std::FILE* file = std::tmpfile();
  REQUIRE(file != nullptr);
  REQUIRE(write(file, value));
  std::string bytes(static_cast<std::size_t>(std::ftell(file)), '\0');
  std::rewind(file);
  REQUIRE(std::fread(bytes.data(), 1, bytes.size(), file) == bytes.size());
  std::fclose(file);
  return bytes;
}

WireInput input_of(std::string_view& rest) {
  return {[&rest](void* to, std::size_t bytes) {
            if (bytes > rest.size()) return false;
            if (bytes > 0) std::memcpy(to, rest.data(), bytes);
            rest.remove_prefix(bytes);
            return true;
          },
          std::uint64_t{1} << 30};
}

Result<Mesh> mesh_from(std::string_view bytes) { return read_mesh(input_of(bytes)); }

Mesh small_mesh() {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}};
  mesh.reflectivity = {0, 0.5f, 1};
  mesh.colors = {{0, 0.5f, 1}, {1, 1, 1}, {0, 0, 0}};
  mesh.uv = {{0, 0}, {-3, 2.5f}, {1e6f, 1}};
  mesh.part = {0};
  mesh.part_names = {"hull"};
  mesh.warnings = {"a warning"};
  return mesh;
}

bool is_nonsense(const Mesh& mesh) {
  const Result<Mesh> read = mesh_from(written(write_mesh, mesh));
  return !read && read.error().kind == ErrorKind::bug;
}

// A program that is started in the importer's place.
struct Impostor {
  TemporaryFolder folder;
  std::filesystem::path path;

  explicit Impostor(const std::string& commands) {
    path = folder.write("importer", "#!/bin/sh\n" + commands + "\n");
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }

  std::string message(std::uint64_t seconds = 60) const {
    const ImportRequest request{
        path, "wreck.obj", {"mesh", "wreck.obj", "1", "face", "material", ""}, {1 << 30, seconds}};
    const Status done = run_import(request, [](const WireInput& in) -> Status {
      const Result<Mesh> mesh = read_mesh(in);
      if (!mesh) return mesh.error();
      return {};
    });
    REQUIRE(!done);
    CHECK(done.error().kind == ErrorKind::usage);
    return done.error().message;
  }
};

TEST_CASE("a mesh is the same through the importer as without it") {
  const TemporaryFolder folder;
  const auto file = folder.write("t.obj", kTriangle);
  for (const Normals normals : {Normals::face, Normals::smooth}) {
    const auto apart = load_mesh(file, {0.1, 0.1, 0.1}, normals);
    const auto here = import_mesh(file, {0.1, 0.1, 0.1}, normals, MeshReflectivity::material);
    REQUIRE(apart.ok());
    REQUIRE(here.ok());
    CHECK(apart->vertices == here->vertices);
    CHECK(apart->normals == here->normals);
    CHECK(apart->triangles == here->triangles);
    CHECK(apart->part_names == here->part_names);
    CHECK(apart->warnings == here->warnings);
  }
  const auto refused = folder.write("n.obj", "v 0 0 nan\n");
  CHECK(load_mesh(refused, {1, 1, 1}, Normals::face).error().message ==
        import_mesh(refused, {1, 1, 1}, Normals::face, MeshReflectivity::material).error().message);
}

TEST_CASE("what goes over the wire comes back") {
  const Mesh mesh = small_mesh();
  const auto read = mesh_from(written(write_mesh, mesh));
  REQUIRE(read.ok());
  CHECK(read->vertices == mesh.vertices);
  CHECK(read->normals == mesh.normals);
  CHECK(read->triangles == mesh.triangles);
  CHECK(read->reflectivity == mesh.reflectivity);
  CHECK(read->colors == mesh.colors);
  CHECK(read->uv == mesh.uv);
  CHECK(read->part == mesh.part);
  CHECK(read->part_names == mesh.part_names);
  CHECK(read->warnings == mesh.warnings);

  DensityGrid grid;
  grid.spacing_m = 0.5;
  grid.origin = {-8, 0, 8};
  grid.bricks = {1, 1, 2};
  grid.top = {-1, 0};
  grid.samples.assign(DensityGrid::kBrickSamples, 0.25f);
  const std::string bytes = written(write_density, grid);
  std::string_view rest = bytes;
  const auto same = read_density(input_of(rest));
  REQUIRE(same.ok());
  CHECK(same->origin == grid.origin);
  CHECK(same->top == grid.top);
  CHECK(same->samples == grid.samples);
  rest = bytes;
  CHECK(read_mesh(input_of(rest)).error().kind == ErrorKind::bug);

  const std::string error = written(write_error, Error{ErrorKind::usage, "why"});
  CHECK(mesh_from(error).error().message == "why");
  CHECK(mesh_from(error).error().kind == ErrorKind::usage);
}

TEST_CASE("what an importer cut short is no mesh") {
  const std::string bytes = written(write_mesh, small_mesh());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const auto read = mesh_from(std::string_view(bytes).substr(0, length));
    REQUIRE(!read);
    REQUIRE(read.error().kind == ErrorKind::bug);
  }
}

TEST_CASE("an importer that was taken over cannot hand on what would be used wrongly") {
  Mesh mesh = small_mesh();
  REQUIRE_FALSE(is_nonsense(mesh));
  SECTION("an index beyond the vertices") { mesh.triangles[0][2] = 3; }
  SECTION("a vertex that is no number") {
    mesh.vertices[1][0] = std::numeric_limits<float>::quiet_NaN();
  }
  SECTION("too few normals") { mesh.normals.pop_back(); }
  SECTION("too many reflectivities") { mesh.reflectivity.push_back(0); }
  SECTION("a reflectivity above 1") { mesh.reflectivity[0] = 2; }
  SECTION("too few colors") { mesh.colors.pop_back(); }
  SECTION("a color above 1") { mesh.colors[2][1] = 1.5f; }
  SECTION("too few texture coordinates") { mesh.uv.pop_back(); }
  SECTION("a texture coordinate that is no number") {
    mesh.uv[2][1] = std::numeric_limits<float>::infinity();
  }
  SECTION("a part without a name") { mesh.part[0] = 1; }
  CHECK(is_nonsense(mesh));
}

TEST_CASE("a count that lies takes no memory") {
  std::string bytes = written(write_mesh, small_mesh());
  const std::uint64_t many = GENERATE(std::uint64_t{1} << 60, std::uint64_t{1} << 26);
  std::memcpy(bytes.data() + 12, &many, sizeof many);  // behind the head: the vertices' count
  const auto read = mesh_from(bytes);
  REQUIRE(!read);
  CHECK(read.error().kind == ErrorKind::bug);
}

TEST_CASE("a crash of the importer is a refusal of the file") {
  CHECK(Impostor("kill -SEGV $$").message() ==
        "wreck.obj: crashes its reader (Segmentation fault); the file is damaged: export it again");
  CHECK(Impostor("exit 3").message().starts_with("wreck.obj: needs more memory than 1.1 GB"));
  CHECK(Impostor("exit 0").message().starts_with("wreck.obj: its reader returned nothing"));
  CHECK(Impostor("echo nonsense").message().starts_with("wreck.obj: its reader returned nothing"));
}

TEST_CASE("an importer without end is ended") {
  CHECK(Impostor("yes").message().starts_with("wreck.obj: its reader returned nothing"));
  CHECK(Impostor("sleep 600").message(1).starts_with("wreck.obj: not read within 1 s"));
  // Closes its output and stays.
  CHECK(Impostor("exec >&-; sleep 600").message(1).starts_with("wreck.obj: not read within 1 s"));
}

#if !defined(ENSONIFY_SANITIZED)
TEST_CASE("a mesh that swells is refused at the limit") {
  const TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 200'000; ++i) text += "v 0.25 0.5 0.75\n";
  for (int i = 0; i < 200'000; ++i) text += "f 1 2 3\n";
  const auto file = folder.write("many.obj", text);
  const auto message = [&](std::uint64_t memory_bytes) {
    const ImportRequest request{importer_path(),
                                file,
                                {"mesh", file.string(), "1", "face", "material", ""},
                                {memory_bytes, 60}};
    const Status done = run_import(request, [](const WireInput& in) -> Status {
      const Result<Mesh> mesh = read_mesh(in);
      if (!mesh) return mesh.error();
      return {};
    });
    return done.error().message;
  };
  // Enough of it is read to see that no face has an area.
  CHECK(message(std::uint64_t{2} << 30).find("all its faces have zero area") != std::string::npos);
  CHECK(message(std::uint64_t{120} << 20) ==
        file.string() +
            ": needs more memory than 0.1 GB; the file is damaged or too large: export it "
            "again, in smaller parts");
}

// A kilobyte of tiles, each of which stands for 128^3 voxels or more.
TEST_CASE("a grid of a thousand million voxels is refused before it is unfolded") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "large.vdb";
  test::VdbGrid grid;
  grid.boxes = {{{0, 0, 0}, {1023, 1023, 1023}, 0.5f}};
  test::write_vdb(file, {grid});
  CHECK(std::filesystem::file_size(file) < 20'000);
  const auto density = load_density_vdb(file, "density");
  CHECK(test::is_refused(density, "at most 524288"));

  // Eight plates, whose surface has a hundred million faces.
  grid.kind = test::VdbKind::level_set;
  grid.background = 0.3f;
  grid.boxes.clear();
  for (int z = 0; z < 2048; z += 256)
    grid.boxes.push_back({{0, 0, z}, {2047, 2047, z + 127}, -0.1f});
  test::write_vdb(file, {grid});
  CHECK(std::filesystem::file_size(file) < 100'000);
  const auto surface = load_level_set_vdb(file, "density", Normals::face);
  REQUIRE_FALSE(surface.ok());
  INFO(surface.error().message);
  CHECK(surface.error().kind == ErrorKind::usage);
  CHECK(surface.error().message.starts_with(file.string() + ": needs more memory than"));
}
#endif

TEST_CASE("a missing importer is told as such") {
  const ImportRequest request{"/nowhere/ensonify_import", "a.obj", {}, {1 << 30, 60}};
  const Status done = run_import(request, [](const WireInput&) -> Status { return {}; });
  REQUIRE(!done);
  CHECK(done.error().kind == ErrorKind::io);
  CHECK(done.error().message.find("/nowhere/ensonify_import") != std::string::npos);
}

}  // namespace
}  // namespace ensonify
