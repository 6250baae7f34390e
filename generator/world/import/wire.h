// What the importer hands to the program over a pipe. Whoever reads it does not trust it: a hostile
// file may have taken the importer over.
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

// Writes to a file; whether all of it went out.
using WireOutput = std::FILE*;
bool write_mesh(WireOutput out, const Mesh& mesh);
bool write_density(WireOutput out, const DensityGrid& grid);
bool write_error(WireOutput out, const Error& error);

struct WireInput {
  // Fills all of the bytes, or says no.
  std::function<bool(void* to, std::size_t bytes)> read;
  std::uint64_t most_bytes = 0;  // of one list: what claims more is refused before memory is taken
};

// The importer's Error; of kind `bug` where what came is not what an importer writes, cut short, or
// no mesh (grid) that may be used: an index beyond its list, a number that is not finite.
Result<Mesh> read_mesh(const WireInput& in);
Result<DensityGrid> read_density(const WireInput& in);

}  // namespace ensonify
