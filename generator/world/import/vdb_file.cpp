#include "world/import/vdb_file.h"

namespace ensonify {
namespace {

std::string names_in(const openvdb::GridPtrVec& grids) {
  std::string names;
  for (const auto& grid : grids) {
    names += (names.empty() ? "" : ", ") + grid->getName();
    if (names.size() > 300) return names + ", ...";
  }
  return names.empty() ? "none" : names;
}

}  // namespace

Result<openvdb::GridBase::Ptr> read_vdb_grid(const std::filesystem::path& path,
                                             const std::string& name) {
  openvdb::initialize();
  openvdb::io::File file(path.string());
  file.open(false);
  if (!name.empty() && file.hasGrid(name)) return file.readGrid(name);
  const openvdb::GridPtrVec grids = *file.readAllGridMetadata();
  if (name.empty() && grids.size() == 1) return file.readGrid(grids[0]->getName());
  if (name.empty()) {
    return Error{ErrorKind::usage, fmt::format("holds {} grids, accepted is `grid` with one of {}",
                                               grids.size(), names_in(grids))};
  }
  return Error{ErrorKind::usage,
               fmt::format("has no grid `{}`, accepted are {}", name, names_in(grids))};
}

Error grid_trouble(const openvdb::GridBase& grid, const std::string& trouble) {
  return {ErrorKind::usage, fmt::format("grid `{}` {}", grid.getName(), trouble)};
}

bool is_near_origin(const openvdb::CoordBBox& box) {
  for (int i = 0; i < 3; ++i) {
    if (box.min()[i] < -kFarthestVdbIndex || box.max()[i] > kFarthestVdbIndex) return false;
  }
  return true;
}

}  // namespace ensonify
