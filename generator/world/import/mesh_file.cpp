#include "world/import/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include "formats/files.h"
#include "world/import/gltf.h"
#include "world/import/stl.h"

namespace ensonify {
namespace {

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

bool is_utf_16(std::string_view bytes) {
  return bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff");
}

// A .gltf may keep its numbers in a second file, which would be neither hashed nor copied with the
// data set. Its buffers must be embedded ("data:" URIs).
Status check_buffers(const std::filesystem::path& file, std::string_view text) {
  const std::size_t buffers = text.find("\"buffers\"");
  const std::size_t end = text.find(']', buffers == std::string::npos ? 0 : buffers);
  for (std::size_t at = buffers; (at = text.find("\"uri\"", at)) < end; at += 5) {
    const std::size_t value = text.find('"', at + 5);
    if (value == std::string::npos || text.compare(value + 1, 5, "data:") == 0) continue;
    const std::string_view name = text.substr(value + 1, text.find('"', value + 1) - value - 1);
    return broken_mesh(
        file, fmt::format("keeps its buffers in a second file, {}; expected .glb, or .gltf "
                          "with embedded buffers",
                          name));
  }
  return {};
}

struct PlyProperty {
  std::size_t bytes = 0;
  std::size_t count_bytes = 0;  // of a list: those of its length
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_lists() const {
    return std::any_of(properties.begin(), properties.end(),
                       [](const PlyProperty& p) { return p.count_bytes > 0; });
  }
};

enum class PlyFormat { ascii, little_endian, big_endian };

struct PlyHead {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::size_t body = 0;  // where it begins
};

std::size_t bytes_of(const std::string& type) {
  constexpr std::pair<std::string_view, std::size_t> kTypes[] = {
      {" char uchar int8 uint8 ", 1},
      {" short ushort int16 uint16 ", 2},
      {" int uint int32 uint32 float float32 ", 4},
      {" double float64 ", 8}};
  for (const auto& [names, bytes] : kTypes) {
    if (names.find(" " + type + " ") != std::string_view::npos) return bytes;
  }
  return 0;
}

// Whether the line is understood.
bool read_head_line(const std::string& line, PlyHead& head) {
  std::istringstream words(line);
  std::string word, type;
  words >> word;
  if (word == "format") {
    words >> type;
    if (type == "binary_little_endian") head.format = PlyFormat::little_endian;
    if (type == "binary_big_endian") head.format = PlyFormat::big_endian;
  } else if (word == "element") {
    PlyElement& element = head.elements.emplace_back();
    return static_cast<bool>(words >> element.name >> element.count);
  } else if (word == "property") {
    PlyProperty property;
    words >> type;
    if (type == "list") {
      words >> type;
      property.count_bytes = bytes_of(type);
      if (property.count_bytes == 0) return false;
      words >> type;
    }
    property.bytes = bytes_of(type);
    if (property.bytes == 0 || head.elements.empty()) return false;
    head.elements.back().properties.push_back(property);
  }
  return true;
}

std::optional<PlyHead> read_head(std::string_view text) {
  PlyHead head;
  while (head.body < text.size()) {
    const std::size_t end = std::min(text.find('\n', head.body), text.size() - 1);
    std::string line(text.substr(head.body, end - head.body));
    if (line.ends_with('\r')) line.pop_back();
    head.body = end + 1;
    if (line == "end_header") return head;
    if (!read_head_line(line, head)) return {};
  }
  return {};
}

// The data after the header, read in steps; false if it ends within a step.
struct PlyBody {
  std::string_view rest;
  PlyFormat format = PlyFormat::ascii;

  bool skip_words(std::uint64_t count, std::string_view* last = nullptr) {
    const auto blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
    for (; count > 0; --count) {
      const auto begin = std::find_if_not(rest.begin(), rest.end(), blank);
      const auto end = std::find_if(begin, rest.end(), blank);
      if (begin == end) return false;
      if (last != nullptr) *last = std::string_view(begin, end);
      rest = std::string_view(end, rest.end());
    }
    return true;
  }

  bool skip(std::uint64_t count, std::size_t bytes) {
    if (format == PlyFormat::ascii) return skip_words(count);
    if (count > rest.size() / bytes) return false;
    rest.remove_prefix(static_cast<std::size_t>(count) * bytes);
    return true;
  }

  bool read_count(std::size_t bytes, std::uint64_t& count) {
    count = 0;
    std::string_view word = rest.substr(0, bytes);
    if (format == PlyFormat::ascii) {
      if (!skip_words(1, &word)) return false;
      std::from_chars(word.data(), word.data() + word.size(), count);
      return true;
    }
    for (std::size_t i = 0; i < word.size(); ++i) {
      const std::size_t at = format == PlyFormat::big_endian ? i : word.size() - 1 - i;
      count = count * 256 + static_cast<unsigned char>(word[at]);
    }
    return skip(1, bytes);
  }
};

bool skip_row(const PlyElement& element, PlyBody& body) {
  for (const PlyProperty& property : element.properties) {
    std::uint64_t count = 1;
    if (property.count_bytes > 0 && !body.read_count(property.count_bytes, count)) return false;
    if (!body.skip(count, property.bytes)) return false;
  }
  return true;
}

Status check_ply(const std::filesystem::path& file, std::string_view text) {
  // Without it, assimp would search forever.
  if (text.find("end_header") == std::string_view::npos) {
    return broken_mesh(
        file,
        "ends before end_header; it is not a PLY file or is cut off: copy or export it again");
  }
  const std::optional<PlyHead> head = read_head(text);
  if (!head) return {};
  PlyBody body{text.substr(head->body), head->format};
  for (const PlyElement& element : head->elements) {
    for (std::uint64_t row = 0; row < element.count && !element.properties.empty(); ++row) {
      if (skip_row(element, body)) continue;
      return broken_mesh(file,
                         fmt::format("ends at {} {} of {}; the file is cut off: copy or export it "
                                     "again",
                                     element.name, row, element.count));
    }
  }
  return {};
}

}  // namespace

Error broken_mesh(const std::filesystem::path& file, const std::string& why) {
  return {ErrorKind::usage, fmt::format("{}: {}", file.string(), why)};
}

std::string lower_case_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

Result<MeshBytes> prepare_mesh_bytes(const std::filesystem::path& file, std::string bytes,
                                     bool uv) {
  const std::string extension = lower_case_extension(file);
  MeshBytes prepared;
  const bool is_stl = extension == ".stl";
  while (bytes.starts_with(kByteOrderMark) && !(is_stl && is_binary_stl(bytes))) {
    bytes.erase(0, kByteOrderMark.size());
    prepared.changed = bytes;
  }
  if (extension != ".dae" && extension != ".glb" && !(is_stl && is_binary_stl(bytes)) &&
      is_utf_16(bytes)) {
    return broken_mesh(file, "is text in UTF-16; save it as UTF-8");
  }
  if (extension == ".gltf" || extension == ".glb") {
    if (Status own = check_buffers(file, bytes); !own && extension == ".gltf") return own.error();
    auto floats = prepare_gltf(file, bytes, uv, prepared.required);
    if (!floats) return floats.error();
    if (*floats) prepared.changed = std::move(**floats);
  }
  if (is_stl) {
    if (Status sound = prepare_stl(file, std::move(bytes), prepared); !sound) return sound.error();
  }
  if (extension == ".ply") {
    if (Status sound = check_ply(file, bytes); !sound) return sound.error();
  }
  return prepared;
}

Result<MeshBytes> prepare_mesh_file(const std::filesystem::path& file, bool uv) {
  // Of these the first bytes tell whether the others matter.
  const std::string extension = lower_case_extension(file);
  if (extension == ".obj" || extension == ".dae") {
    std::string head(kByteOrderMark.size(), '\0');
    std::ifstream(file, std::ios::binary)
        .read(head.data(), static_cast<std::streamsize>(head.size()));
    if (head != kByteOrderMark && !is_utf_16(head)) return MeshBytes{};
  }
  Result<std::string> bytes = read_file(file);
  if (!bytes) return MeshBytes{};  // the reader says why
  return prepare_mesh_bytes(file, std::move(*bytes), uv);
}

namespace {

bool has_area(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  std::array<Vec3, 3> corner;
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& v = mesh.vertices[triangle[i]];
    corner[i] = to_vec3(v);
    for (const float x : v) largest = std::max(largest, std::abs(static_cast<double>(x)));
  }
  const Vec3 ab = corner[1] - corner[0], ac = corner[2] - corner[0], bc = corner[2] - corner[1];
  const double longest = std::max({length(ab), length(ac), length(bc)});
  const double rounding = std::numeric_limits<float>::epsilon() * largest;
  return length(cross(ab, ac)) > rounding * longest;
}

}  // namespace

Status check_extent(const Mesh& mesh, const std::filesystem::path& file) {
  constexpr double kMostM = 1e6, kMostRoundingM = 0.01;
  Bounds bounds;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    for (const float coordinate : mesh.vertices[v]) {
      if (std::isfinite(coordinate)) continue;
      return broken_mesh(file, fmt::format("vertex {} is not a finite number", v));
    }
  }
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) bounds.add(to_vec3(mesh.vertices[vertex]));
  }
  if (bounds.empty()) return {};
  const Vec3 size = bounds.size(), middle = bounds.middle();
  const double longest = std::max({size.x, size.y, size.z});
  if (longest > kMostM) {
    return broken_mesh(file, fmt::format("is {:.3g} x {:.3g} x {:.3g} m large; expected at most "
                                         "1000 km: set scale to the file's unit, or export it "
                                         "again if it is damaged",
                                         size.x, size.y, size.z));
  }
  const double farthest = std::max({std::abs(middle.x), std::abs(middle.y), std::abs(middle.z)});
  // Between two numbers next to each other.
  const double step = std::exp2(std::floor(std::log2(std::max(farthest, 1.0))) - 23);
  if (step < kMostRoundingM || farthest < 4 * longest) return {};
  const auto rounded = [](double x) { return 100 * std::round(x / 100) + 0.0; };
  return broken_mesh(
      file, fmt::format("lies around ({:.0f}, {:.0f}, {:.0f}) m, where single precision rounds its "
                        "coordinates to {:.2g} m; subtract this origin from the coordinates before "
                        "the export, and place the object with pose.position_m",
                        rounded(middle.x), rounded(middle.y), rounded(middle.z), step));
}

void drop_faces_without_area(Mesh& mesh) {
  const std::size_t before = mesh.triangles.size();
  std::size_t kept = 0;
  for (std::size_t t = 0; t < before; ++t) {
    if (!has_area(mesh, mesh.triangles[t])) continue;
    mesh.triangles[kept] = mesh.triangles[t];
    if (!mesh.part.empty()) mesh.part[kept] = mesh.part[t];
    ++kept;
  }
  mesh.triangles.resize(kept);
  if (!mesh.part.empty()) mesh.part.resize(kept);
  const std::size_t dropped = before - mesh.triangles.size();
  if (dropped == 0) return;
  mesh.warnings.push_back(fmt::format(
      "ignored {} of {} faces: they have zero area (corners that coincide or lie on one "
      "line)",
      dropped, before));
}

}  // namespace ensonify
