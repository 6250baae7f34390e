#include "world/import/gltf.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "formats/bytes.h"
#include "formats/json.h"
#include "world/import/import.h"

namespace ensonify {
namespace {

constexpr std::uint64_t kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123,
                        kUnsignedInt = 5125, kFloat = 5126;
constexpr std::uint64_t kMostVertices = std::uint64_t{1} << 32;

// Extensions of materials, images, lights and animations do not change the surface.
bool is_supported(std::string_view extension) {
  for (const std::string_view looks :
       {"KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_",
        "EXT_lights_", "KHR_animation_", "KHR_xmp"}) {
    if (extension.starts_with(looks)) return true;
  }
  // assimp of Debian reads Draco.
  return extension == "KHR_mesh_quantization" || extension == "KHR_draco_mesh_compression";
}

const Json* element(const Json& json, std::string_view list, std::uint64_t index) {
  const Json* all = member(json, list);
  return all != nullptr && all->is_array() && index < all->size() ? &(*all)[index] : nullptr;
}

std::uint64_t count_or(const Json& json, std::string_view key, std::uint64_t missing) {
  return count_at(json, key).value_or(missing);
}

std::size_t bytes_of(std::uint64_t component) {
  if (component == kByte || component == kUnsignedByte) return 1;
  if (component == kShort || component == kUnsignedShort) return 2;
  return component == kUnsignedInt || component == kFloat ? 4 : 0;
}

std::size_t components_of(const Json& accessor) {
  const std::string type = text_at(accessor, "type").value_or("");
  return type == "VEC2" ? 2 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 0;
}

// The number at the beginning of the bytes, as glTF 2.0 defines it (section 3.6.2.2).
float number_of(std::string_view bytes, std::uint64_t component, bool normalized) {
  const auto scaled = [&](auto value, float largest) {
    const auto number = static_cast<float>(value);
    return normalized ? std::max(number / largest, -1.0f) : number;
  };
  if (component == kByte) return scaled(value_at<std::int8_t>(bytes, 0), 127);
  if (component == kUnsignedByte) return scaled(value_at<std::uint8_t>(bytes, 0), 255);
  if (component == kShort) return scaled(value_at<std::int16_t>(bytes, 0), 32767);
  if (component == kUnsignedShort) return scaled(value_at<std::uint16_t>(bytes, 0), 65535);
  return value_at<float>(bytes, 0);
}

// Of texture coordinates: offset, scale and sine and cosine of the rotation.
struct UvTransform {
  std::array<float, 2> offset{0, 0}, scale{1, 1};
  float sine = 0, cosine = 1;
};

std::array<float, 2> pair_at(const Json& json, std::string_view key, std::array<float, 2> missing) {
  const Json* pair = member(json, key);
  if (pair == nullptr || !pair->is_array() || pair->size() != 2) return missing;
  if (!(*pair)[0].is_number() || !(*pair)[1].is_number()) return missing;
  return {(*pair)[0].get<float>(), (*pair)[1].get<float>()};
}

// Ends at the first character that is no digit.
std::string bytes_of_base64(std::string_view text) {
  std::string bytes;
  std::uint32_t word = 0;
  int bits = 0;
  for (const char c : text) {
    const std::uint32_t digit = c >= 'A' && c <= 'Z'   ? c - 'A'
                                : c >= 'a' && c <= 'z' ? c - 'a' + 26
                                : c >= '0' && c <= '9' ? c - '0' + 52
                                : c == '+'             ? 62
                                : c == '/'             ? 63
                                                       : 64;
    if (digit == 64) break;
    word = word << 6 | digit;
    if ((bits += 6) < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(word >> bits & 255);
  }
  return bytes;
}

// A glTF file whose accessors are replaced by others of floats.
class Gltf {
 public:
  Gltf(const std::filesystem::path& file, Json json, std::string_view binary)
      : file_(file), json_(std::move(json)), binary_(binary) {
    // Before references into them are taken.
    for (const char* list : {"accessors", "bufferViews", "buffers"}) {
      if (!json_.contains(list)) json_[list] = Json::array();
    }
  }

  const Json& json() const { return json_; }
  bool changed() const { return !floats_.empty(); }

  // Replaces those of one primitive of a mesh.
  Status replace(Json& primitive, bool uv) {
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object()) return {};
    for (auto& [name, index] : attributes->items()) {
      const bool is_uv = name.starts_with("TEXCOORD_");
      if (name != "POSITION" && name != "NORMAL" && name != "TANGENT" && !is_uv) continue;
      const Json* accessor = index.is_number_unsigned()
                                 ? element(json_, "accessors", index.get<std::uint64_t>())
                                 : nullptr;
      if (accessor == nullptr) continue;  // the reader refuses it
      std::optional<UvTransform> transform;
      if (uv && name == "TEXCOORD_0") transform = transform_of(primitive);
      if (count_or(*accessor, "componentType", kFloat) == kFloat && !transform) continue;
      const Json* extensions = member(primitive, "extensions");
      if (extensions != nullptr && member(*extensions, "KHR_draco_mesh_compression") != nullptr) {
        return broken_mesh(file_,
                           "combines KHR_draco_mesh_compression with whole numbers or "
                           "KHR_texture_transform, which is not supported; export it "
                           "without compression");
      }
      const auto replaced = floats_of(index.get<std::uint64_t>(), transform);
      if (!replaced) return replaced.error();
      index = *replaced;
    }
    if (changed()) primitive.erase("targets");  // shapes of animations, perhaps of whole numbers
    return {};
  }

  Status replace_all(bool uv) {
    const auto meshes = json_.find("meshes");
    if (meshes == json_.end() || !meshes->is_array()) return {};
    for (Json& mesh : *meshes) {
      if (!mesh.is_object() || !mesh.contains("primitives")) continue;
      for (Json& primitive : mesh["primitives"]) {
        if (!primitive.is_object()) continue;
        if (Status done = replace(primitive, uv); !done) return done;
      }
    }
    return {};
  }

  // The file with the floats in a buffer of their own.
  std::string text() {
    json_["buffers"].push_back(
        {{"byteLength", floats_.size()},
         {"uri", "data:application/octet-stream;base64," + base64(floats_)}});
    std::string json = json_.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (binary_.empty()) return json;
    json.append((4 - json.size() % 4) % 4, ' ');
    std::string bytes = "glTF";
    const auto put = [&](std::size_t number) {
      put_value(bytes, static_cast<std::uint32_t>(number));
    };
    put(2);
    put(12 + 8 + json.size() + 8 + binary_.size());
    put(json.size());
    bytes += "JSON" + json;
    put(binary_.size());
    return (bytes += std::string_view("BIN\0", 4)) += binary_;
  }

 private:
  Error damaged(std::uint64_t accessor, const std::string& why) const {
    return broken_mesh(
        file_, fmt::format("accessor {} {}; the file is damaged: export it again", accessor, why));
  }

  // That of the base color, if it applies to the first texture coordinates.
  std::optional<UvTransform> transform_of(const Json& primitive) const {
    const Json* json = element(json_, "materials", count_or(primitive, "material", UINT64_MAX));
    for (const char* key :
         {"pbrMetallicRoughness", "baseColorTexture", "extensions", "KHR_texture_transform"}) {
      json = json == nullptr ? nullptr : member(*json, key);
    }
    if (json == nullptr || count_or(*json, "texCoord", 0) != 0) return {};
    const double rotation = number_at(*json, "rotation").value_or(0);
    return UvTransform{pair_at(*json, "offset", {0, 0}), pair_at(*json, "scale", {1, 1}),
                       static_cast<float>(std::sin(rotation)),
                       static_cast<float>(std::cos(rotation))};
  }

  // The bytes of a buffer; empty if they are missing.
  std::string_view buffer(std::uint64_t index) {
    const Json* json = element(json_, "buffers", index);
    const auto uri = json == nullptr ? std::nullopt : text_at(*json, "uri");
    if (!uri) return index == 0 ? binary_ : std::string_view{};
    const auto [at, is_new] = decoded_.try_emplace(index);
    const std::size_t comma = uri->find(";base64,");
    if (is_new && comma != std::string::npos) {
      at->second = bytes_of_base64(std::string_view(*uri).substr(comma + 8));
    }
    return at->second;
  }

  // `count` elements of a view from `offset` on, `stride` bytes apart (0: the view's or their
  // size); none if they are not all there.
  std::optional<std::string_view> elements(std::uint64_t view, std::uint64_t offset,
                                           std::uint64_t count, std::size_t size,
                                           std::size_t* stride) {
    const Json* json = element(json_, "bufferViews", view);
    if (json == nullptr) return {};
    const std::uint64_t begin = count_or(*json, "byteOffset", 0);
    const std::uint64_t length = count_or(*json, "byteLength", 0);
    const std::string_view all = buffer(count_or(*json, "buffer", UINT64_MAX));
    if (begin > all.size() || length > all.size() - begin) return {};
    *stride = count_or(*json, "byteStride", 0);
    if (*stride == 0) *stride = size;
    if (*stride > 255 || offset > length || count > length) return {};
    if (count > 0 && (count - 1) * *stride + size > length - offset) return {};
    return all.substr(begin + offset, length - offset);
  }

  // The numbers of an accessor.
  Result<std::vector<float>> numbers_of(std::uint64_t index) {
    const Json& accessor = json_["accessors"][index];
    const std::uint64_t component = count_or(accessor, "componentType", 0);
    const std::size_t parts = components_of(accessor), size = bytes_of(component) * parts;
    if (size == 0 || component == kUnsignedInt) {
      return damaged(index, fmt::format("has the type {} of components {}, which glTF does not "
                                        "allow for vertices",
                                        text_at(accessor, "type").value_or("?"), component));
    }
    const Json* normal = member(accessor, "normalized");
    const bool normalized = normal != nullptr && normal->is_boolean() && normal->get<bool>();
    const std::uint64_t count = count_or(accessor, "count", 0);
    std::vector<float> numbers;
    const auto put = [&](std::string_view bytes, std::size_t stride, std::uint64_t from,
                         std::uint64_t to) {
      for (std::size_t i = 0; i < parts; ++i) {
        numbers[to * parts + i] =
            number_of(bytes.substr(from * stride + i * bytes_of(component)), component, normalized);
      }
    };
    if (count > kMostVertices) return damaged(index, fmt::format("claims {} vertices", count));
    std::size_t stride = 0;
    if (const auto view = count_at(accessor, "bufferView")) {
      const auto bytes = elements(*view, count_or(accessor, "byteOffset", 0), count, size, &stride);
      if (!bytes) return damaged(index, "ends beyond its buffer");
      numbers.resize(count * parts);
      for (std::uint64_t i = 0; i < count; ++i) put(*bytes, stride, i, i);
    } else {
      numbers.resize(count * parts);
    }
    const Status changed = apply_sparse(index, put, count, size);
    if (!changed) return changed.error();
    return numbers;
  }

  // Puts the values of a sparse accessor over those of its view.
  template <class Put>
  Status apply_sparse(std::uint64_t index, const Put& put, std::uint64_t count, std::size_t size) {
    const Json* sparse = member(json_["accessors"][index], "sparse");
    if (sparse == nullptr) return {};
    const Json *places = member(*sparse, "indices"), *values = member(*sparse, "values");
    if (places == nullptr || values == nullptr) return damaged(index, "lacks its sparse values");
    const std::uint64_t changes = count_or(*sparse, "count", 0);
    const std::size_t place_bytes = bytes_of(count_or(*places, "componentType", 0));
    std::size_t place_stride = 0, stride = 0;
    const auto at =
        elements(count_or(*places, "bufferView", UINT64_MAX), count_or(*places, "byteOffset", 0),
                 changes, place_bytes, &place_stride);
    const auto bytes = elements(count_or(*values, "bufferView", UINT64_MAX),
                                count_or(*values, "byteOffset", 0), changes, size, &stride);
    if (!at || !bytes || place_bytes == 0) return damaged(index, "ends beyond its buffer");
    for (std::uint64_t i = 0; i < changes; ++i) {
      std::uint64_t to = 0;
      for (std::size_t b = place_bytes; b-- > 0;) {
        to = to * 256 + static_cast<unsigned char>((*at)[i * place_stride + b]);
      }
      if (to >= count) return damaged(index, fmt::format("changes vertex {} of {}", to, count));
      put(*bytes, stride, i, to);
    }
    return {};
  }

  // The index of a new accessor.
  Result<std::uint64_t> floats_of(std::uint64_t index,
                                  const std::optional<UvTransform>& transform) {
    const auto old = replaced_.find(index);
    if (old != replaced_.end() && !transform) return old->second;
    auto numbers = numbers_of(index);
    if (!numbers) return numbers.error();
    if (transform) {
      const auto& [offset, scale, sine, cosine] = *transform;
      for (std::size_t i = 0; i + 1 < numbers->size(); i += 2) {
        const float u = scale[0] * (*numbers)[i], v = scale[1] * (*numbers)[i + 1];
        (*numbers)[i] = cosine * u + sine * v + offset[0];
        (*numbers)[i + 1] = cosine * v - sine * u + offset[1];
      }
    }
    const std::size_t bytes = numbers->size() * sizeof(float);
    json_["bufferViews"].push_back({{"buffer", json_["buffers"].size()},
                                    {"byteOffset", floats_.size()},
                                    {"byteLength", bytes}});
    floats_.append(reinterpret_cast<const char*>(numbers->data()), bytes);
    Json accessor = json_["accessors"][index];
    for (const char* key : {"min", "max", "normalized", "sparse", "byteOffset"})
      accessor.erase(key);
    accessor["componentType"] = kFloat;
    accessor["bufferView"] = json_["bufferViews"].size() - 1;
    json_["accessors"].push_back(std::move(accessor));
    const std::uint64_t added = json_["accessors"].size() - 1;
    if (!transform) replaced_[index] = added;
    return added;
  }

  std::filesystem::path file_;
  Json json_;
  std::string_view binary_;  // that of a .glb
  std::string floats_;
  std::map<std::uint64_t, std::string> decoded_;
  std::map<std::uint64_t, std::uint64_t> replaced_;  // accessors
};

// The JSON and the binary part of a .glb; all of it as JSON if it is not one.
std::pair<std::string_view, std::string_view> parts_of(std::string_view bytes) {
  if (!bytes.starts_with("glTF")) return {bytes, {}};
  if (bytes.size() < 20) return {};
  const std::size_t length = value_at<std::uint32_t>(bytes, 12);
  if (length > bytes.size() - 20) return {};
  const std::string_view json = bytes.substr(20, length), rest = bytes.substr(20 + length);
  if (rest.size() < 8 || rest.substr(4, 4) != std::string_view("BIN\0", 4)) return {json, {}};
  return {json, rest.substr(8, value_at<std::uint32_t>(rest, 0))};
}

}  // namespace

Result<std::optional<std::string>> prepare_gltf(const std::filesystem::path& file,
                                                std::string_view bytes, bool uv,
                                                std::vector<std::string>& required) {
  const auto [text, binary] = parts_of(bytes);
  std::optional<Json> json = parse_json(text);
  if (!json || !json->is_object()) return std::optional<std::string>();
  for (const char* list : {"accessors", "bufferViews", "buffers"}) {
    if (json->contains(list) && !(*json)[list].is_array()) return std::optional<std::string>();
  }
  if (const Json* names = member(*json, "extensionsRequired"); names != nullptr) {
    for (const Json& name : *names) {
      if (name.is_string()) required.push_back(name.get<std::string>());
    }
  }
  std::string refused;
  for (const std::string& name : required) {
    if (!is_supported(name)) refused += (refused.empty() ? "" : ", ") + name;
  }
  if (!refused.empty()) {
    return broken_mesh(file, fmt::format("requires {}, which is not supported; export it without "
                                         "this extension of glTF",
                                         refused));
  }
  Gltf gltf(file, std::move(*json), binary);
  if (Status done = gltf.replace_all(uv); !done) return done.error();
  return gltf.changed() ? std::optional(gltf.text()) : std::nullopt;
}

}  // namespace ensonify
