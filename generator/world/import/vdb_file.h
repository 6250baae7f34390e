// What reading OpenVDB files has in common. For the sources that include OpenVDB only.
#pragma once

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <filesystem>
#include <new>
#include <optional>
#include <string>

#include "core/error.h"

namespace ensonify {

// One grid of the file, by name, or the only one where `name` is empty. Throws as OpenVDB does.
Result<openvdb::GridBase::Ptr> read_vdb_grid(const std::filesystem::path& file,
                                             const std::string& name);

// What is wrong with a grid; none where it can be used.
using GridTrouble = std::optional<std::string>;

// "grid `density` " + trouble.
Error grid_trouble(const openvdb::GridBase& grid, const std::string& trouble);

// A coordinate that may be counted on from.
bool is_near_origin(const openvdb::CoordBBox& box);
inline constexpr int kFarthestVdbIndex = 1 << 30;

// Runs `load`, names the file in its errors, and turns what OpenVDB throws into one. On this
// thread alone: all threads come from core/parallel.h, and OpenVDB would start some to count and to
// free.
template <class Load>
auto load_from_vdb(const std::filesystem::path& file, Load load) -> decltype(load()) {
  const auto refuse = [&](const std::string& trouble) {
    return Error{ErrorKind::usage, fmt::format("{}: {}", file.string(), trouble)};
  };
  try {
    auto loaded = tbb::task_arena(1).execute(load);
    if (!loaded) return refuse(loaded.error().message);
    return loaded;
  } catch (const std::bad_alloc&) {
    throw;  // main.cpp's
  } catch (const std::exception& e) {
    std::string what = e.what();
    std::replace(what.begin(), what.end(), '\n', ' ');
    return refuse(fmt::format("cannot be read ({}), accepted is an OpenVDB file", what));
  }
}

}  // namespace ensonify
