#include "world/import/wire.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace ensonify {
namespace {

constexpr std::uint64_t kMagic = 0x32796669'6e6f736eu;
enum class Payload : std::uint32_t { mesh = 1, density = 2, error = 3 };
constexpr std::uint64_t kMostTexts = 4096, kMostTextBytes = 1 << 20;

template <class T>
bool put(WireOutput out, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  return std::fwrite(&value, sizeof value, 1, out) == 1;
}

template <class T>
bool put_list(WireOutput out, const std::vector<T>& list) {
  static_assert(std::is_trivially_copyable_v<T>);
  return put(out, std::uint64_t{list.size()}) &&
         (list.empty() || std::fwrite(list.data(), sizeof(T), list.size(), out) == list.size());
}

bool put_text(WireOutput out, const std::string& text) {
  return put(out, std::uint64_t{text.size()}) &&
         std::fwrite(text.data(), 1, text.size(), out) == text.size();
}

bool put_texts(WireOutput out, const std::vector<std::string>& texts) {
  return put(out, std::uint64_t{texts.size()}) &&
         std::all_of(texts.begin(), texts.end(),
                     [&](const std::string& text) { return put_text(out, text); });
}

bool put_head(WireOutput out, Payload payload) { return put(out, kMagic) && put(out, payload); }

template <class T>
bool get(const WireInput& in, T& value) {
  return in.read(&value, sizeof value);
}

template <class T>
bool get_list(const WireInput& in, std::vector<T>& list) {
  std::uint64_t count = 0;
  if (!get(in, count) || count > in.most_bytes / sizeof(T)) return false;
  // Reads in pieces, so that a wrong count does not use more memory than the data.
  constexpr std::uint64_t kPiece = (std::uint64_t{4} << 20) / sizeof(T);
  list.reserve(static_cast<std::size_t>(count));
  while (list.size() < count) {
    const std::size_t at = list.size();
    list.resize(at + static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, count - at)));
    if (!in.read(list.data() + at, (list.size() - at) * sizeof(T))) return false;
  }
  return true;
}

bool get_text(const WireInput& in, std::string& text) {
  std::uint64_t bytes = 0;
  if (!get(in, bytes) || bytes > kMostTextBytes) return false;
  text.resize(static_cast<std::size_t>(bytes));
  return in.read(text.data(), text.size());
}

bool get_texts(const WireInput& in, std::vector<std::string>& texts) {
  std::uint64_t count = 0;
  if (!get(in, count) || count > kMostTexts) return false;
  for (; count > 0; --count) {
    if (!get_text(in, texts.emplace_back())) return false;
  }
  return true;
}

const Error kNonsense{ErrorKind::bug, "returned nothing usable"};

// Returns none if the payload follows; otherwise the importer's error, or kNonsense.
std::optional<Error> read_head(const WireInput& in, Payload wanted) {
  std::uint64_t magic = 0;
  Payload payload{};
  if (!get(in, magic) || magic != kMagic || !get(in, payload)) return kNonsense;
  if (payload == wanted) return {};
  std::uint32_t kind = 0;
  Error error;
  if (payload != Payload::error || !get(in, kind) || !get_text(in, error.message)) {
    return kNonsense;
  }
  error.kind = kind == static_cast<std::uint32_t>(ErrorKind::io) ? ErrorKind::io : ErrorKind::usage;
  return error;
}

template <std::size_t N>
bool is_finite(const std::vector<std::array<float, N>>& points) {
  return std::all_of(points.begin(), points.end(), [](const auto& p) {
    return std::all_of(p.begin(), p.end(), [](float x) { return std::isfinite(x); });
  });
}

bool is_sound(const Mesh& mesh) {
  const std::size_t vertices = mesh.vertices.size();
  const auto all_or_none = [](std::size_t have, std::size_t all) {
    return have == 0 || have == all;
  };
  if (!is_finite(mesh.vertices) || !is_finite(mesh.uv)) return false;
  if (!all_or_none(mesh.normals.size(), vertices)) return false;
  if (!all_or_none(mesh.reflectivity.size(), vertices)) return false;
  if (!all_or_none(mesh.colors.size(), vertices)) return false;
  if (!all_or_none(mesh.uv.size(), vertices)) return false;
  if (!all_or_none(mesh.part.size(), mesh.triangles.size())) return false;
  for (const auto& triangle : mesh.triangles) {
    if (std::max({triangle[0], triangle[1], triangle[2]}) >= vertices) return false;
  }
  return std::all_of(mesh.part.begin(), mesh.part.end(),
                     [&](std::uint8_t part) { return part < mesh.part_names.size(); }) &&
         std::all_of(mesh.reflectivity.begin(), mesh.reflectivity.end(),
                     [](float factor) { return factor >= 0 && factor <= 1; }) &&
         std::all_of(mesh.colors.begin(), mesh.colors.end(), [](const auto& color) {
           // The negated comparison lets NaN pass.
           return std::all_of(color.begin(), color.end(),
                              [](float channel) { return !(channel < 0 || channel > 1); });
         });
}

bool is_sound(const DensityGrid& grid) {
  std::uint64_t cells = 1;
  for (const int bricks : grid.bricks) {
    if (bricks <= 0 || static_cast<std::uint64_t>(bricks) > kMaxTopCells) return false;
    cells *= static_cast<std::uint64_t>(bricks);
    if (cells > kMaxTopCells) return false;
  }
  const std::size_t bricks = grid.samples.size() / DensityGrid::kBrickSamples;
  if (grid.top.size() != cells || bricks > kMaxBricks) return false;
  if (grid.samples.size() != bricks * DensityGrid::kBrickSamples) return false;
  const Affine& affine = grid.index_from_local;
  double all = grid.spacing_m + length(affine.offset);
  for (const Vec3& row : affine.rows) all += length(row);
  if (!(grid.spacing_m > 0) || !std::isfinite(all)) return false;
  return std::all_of(grid.top.begin(), grid.top.end(),
                     [&](std::int32_t brick) {
                       return brick >= -1 && brick < static_cast<std::int64_t>(bricks);
                     }) &&
         std::all_of(grid.samples.begin(), grid.samples.end(),
                     [](float density) { return density >= 0 && std::isfinite(density); });
}

}  // namespace

bool write_mesh(WireOutput out, const Mesh& mesh) {
  return put_head(out, Payload::mesh) && put_list(out, mesh.vertices) &&
         put_list(out, mesh.normals) && put_list(out, mesh.triangles) &&
         put_list(out, mesh.reflectivity) && put_list(out, mesh.colors) && put_list(out, mesh.uv) &&
         put_list(out, mesh.part) && put_texts(out, mesh.part_names) &&
         put_texts(out, mesh.warnings);
}

bool write_density(WireOutput out, const DensityGrid& grid) {
  return put_head(out, Payload::density) && put(out, grid.index_from_local) &&
         put(out, grid.spacing_m) && put(out, grid.origin) && put(out, grid.bricks) &&
         put_list(out, grid.top) && put_list(out, grid.samples);
}

bool write_error(WireOutput out, const Error& error) {
  return put_head(out, Payload::error) && put(out, static_cast<std::uint32_t>(error.kind)) &&
         put_text(out, error.message.substr(0, kMostTextBytes));
}

Result<Mesh> read_mesh(const WireInput& in) {
  if (const std::optional<Error> error = read_head(in, Payload::mesh)) return *error;
  Mesh mesh;
  const bool whole =
      get_list(in, mesh.vertices) && get_list(in, mesh.normals) && get_list(in, mesh.triangles) &&
      get_list(in, mesh.reflectivity) && get_list(in, mesh.colors) && get_list(in, mesh.uv) &&
      get_list(in, mesh.part) && get_texts(in, mesh.part_names) && get_texts(in, mesh.warnings);
  if (!whole || !is_sound(mesh)) return kNonsense;
  return mesh;
}

Result<DensityGrid> read_density(const WireInput& in) {
  if (const std::optional<Error> error = read_head(in, Payload::density)) return *error;
  DensityGrid grid;
  const bool whole = get(in, grid.index_from_local) && get(in, grid.spacing_m) &&
                     get(in, grid.origin) && get(in, grid.bricks) && get_list(in, grid.top) &&
                     get_list(in, grid.samples);
  if (!whole || !is_sound(grid)) return kNonsense;
  return grid;
}

}  // namespace ensonify
