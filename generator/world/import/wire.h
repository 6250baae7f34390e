// The format in which the importer sends data to the program through a pipe. The reader does not
// trust it, since a hostile file may have taken over the importer.
//
//   WireOutput  write_mesh  write_density  write_error
//   WireInput   read_mesh   read_density
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <functional>

#include "core/error.h"
#include "world/density.h"
#include "world/mesh.h"

namespace ensonify {

// Writes to a file; returns whether all bytes were written.
using WireOutput = std::FILE*;
bool write_mesh(WireOutput out, const Mesh& mesh);
bool write_density(WireOutput out, const DensityGrid& grid);
bool write_error(WireOutput out, const Error& error);

struct WireInput {
  // Fills all bytes, or returns false.
  std::function<bool(void* to, std::size_t bytes)> read;
  std::uint64_t most_bytes = 0;  // of one list; larger ones are refused before allocating
};

// The importer's Error; of kind `bug` if the data are malformed, cut off, or not a usable mesh or
// grid, as with an index beyond its list or a number that is not finite.
Result<Mesh> read_mesh(const WireInput& in);
Result<DensityGrid> read_density(const WireInput& in);

}  // namespace ensonify
