#include "scenario_schema.h"

#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

#include "json_schema.h"
#include "scenario/rig.h"
#include "scenario/text.h"
#include "scenario_texts.h"

namespace ensonify::testing {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

// What a reference stands for.
const Json& definition(const Json& use) {
  return schema().at(Json::json_pointer(use.at("$ref").get<std::string>().substr(1)));
}

// The first of `use`, and of all that it stands for, that `fits`.
const Json* find_schema(const Json& use, const std::function<bool(const Json&)>& fits) {
  if (use.contains("$ref")) return find_schema(definition(use), fits);
  if (fits(use)) return &use;
  for (const char* key : {"allOf", "anyOf"}) {
    if (!use.contains(key)) continue;
    for (const Json& part : use.at(key)) {
      if (const Json* found = find_schema(part, fits)) return found;
    }
  }
  return nullptr;
}

// The type, or one that a variable may stand for.
bool is_type(const Json& node, const Json& type, const Json& or_variable) {
  return node.contains("type") && (node.at("type") == type || node.at("type") == or_variable);
}

// Whatever the scenes and the documentation leave out.
const char* const kMore[] = {
    R"(ensonify: 1
sonar:
  frequency_hz: 9e5
  bandwidth_hz: 3e4
  source_level_db: 200
  range_max_m: 10
  beams: {count: 64, fov_deg: 60, receive_width_deg: 1, shading: {uniform: {}}}
  elevation: {width_deg: 20}
  rays: {elevation: 8}
  pulse: {flat: {}}
  receiver: {adc: {bits: 12, full_scale_db: 170}}
water: {absorption: {fixed_db_m: 0.1}}
motion_within_ping: true
noise: {snr_db: 20}
multipath: {surface: {z_m: 1, reflection: -1}, bottom: {z_m: -9, reflection: 0.3}, objects: true}
synthesis: {tolerance: 1e-6}
output: {polar: {}, multipath: {}, scatterers: {}, png: {db: [60, 120]}, cartesian: {}, sdf: {voxel_m: 1}, world: true, height_map: {spacing_m: 1}}
)",
    R"(ensonify: 1
sonar: {preset: blueview_p900_90, pulse: {cw: {duration_s: 1e-4}}, beams: {shading: {chebyshev: {}}}}
materials:
  a: {reflectivity: 1, law: {lambert: {}}, coherent: {model: kirchhoff}}
  b: {reflectivity: 1, law: {lommel_seeliger: {}}}
objects:
  - {name: file, material: a, shape: {heightfield: {file: a.npy, cell_m: 1, reflectivity_map: a.png}}}
  - {name: made, material: a, shape: {heightfield: {size_m: [4, 4], cell_m: 1, roughness: {rms_m: 0}, patches: [{share: 0, correlation_m: 2}], stones: [{density_per_m2: 0, diameter_m: [2, 2]}]}}}
  - {name: mesh, material: b, shape: {mesh: {file: a.obj}}, trajectory: {file: a.tum}}
  - {name: way, material: b, shape: {sphere: {radius_m: 1}}, trajectory: {poses: [{}], wave_motion: {period_s: 5}}}
  - {name: lawn, material: b, shape: {sphere: {radius_m: 1}}, trajectory: {lawnmower: {corner_m: [0, 0, 0], length_m: 9, width_m: 4, spacing_m: 2, speed_m_s: 1}}}
  - {name: orbit, material: b, shape: {box: {size_m: [1, 1, 1]}}, trajectory: {orbit: {center_m: [0, 0, 0], radius_m: 9, speed_m_s: 1}}}
  - {name: solid, material: b, shape: {level_set: {file: a.vdb}}}
  - {name: parts, material: b, shape: {mesh: {file: a.obj, parts: {hull: a}, reflectivity: texture, texture_file: a.png}}}
  - {name: lies, material: b, shape: {box: {size_m: [1, 1, 1]}}, place: {on: made, area_m: [[0, 0], [1, 1]], scour: {depth_m: 0, width_m: 1}}}
point_targets: [{name: p, target_strength_db: 0, position_m: [1, 0, 0]}]
volumes:
  - {name: cloud, vdb: {file: a.vdb, strength_db: -30}}
  - {name: leak, plume: {radius_m: 0.2, height_m: 5, strength_db: -20}}
  - {name: haze, uniform: {strength_db: -50, size_m: [1, 1, 1], patches: {model: gamma, shape: 2, correlation_m: 1}}}
trajectory: {file: a.csv}
)",
    R"(ensonify: 1
sonar: {preset: blueview_p900_90, pulse: {table: {file: a.csv}}, beams: {shading: {taylor: {}}}, receiver: {mode: array}}
water: {absorption: {model: ainslie_mccolm}, profile: {file: a.csv}}
output: {channels: true}
trajectory: {spline: {points_m: [[0, 0, 0], [1, 0, 0]], speed_m_s: 1, look: {at_m: [0, 0, 0]}}}
)",
    R"(ensonify: 1
sonar: {preset: blueview_p900_90, pulse: {gaussian: {}}, beams: {shading: {hann: {}}}, mount: {},
        receiver: {mode: array, elements: 8, spacing_m: 1e-3, element_width_m: 5e-4, focus: none, dead: [1],
                   shading: {taylor: {}}, steering: phase, gain_error_db: 1, phase_error_deg: 2}}
scattering: {}
water: {profile: {depth_m: [0, 10], sound_speed_m_s: [1500, 1510]}}
output: {}
trajectory: {spline: {points_m: [[0, 0, 0], [1, 0, 0]], speed_m_s: 1, look: {along: {}}}}
)"};

const test::JsonSchema& checked_schema() {
  static const test::JsonSchema checked([] {
    Json known = schema();
    // Valijson takes an unsigned number that fits no signed one for a negative one.
    known["properties"]["seed"]["maximum"] = 18446744073709551615.0;
    return known;
  }());
  return checked;
}

}  // namespace

const Json& schema() {
  static const Json json = Json::parse(read(ENSONIFY_SCHEMA));
  return json;
}

const Json* map_schema(const Json& use) {
  return find_schema(use, [](const Json& node) {
    return is_type(node, "object", {"object", "string"});
  });
}

const Json* list_schema(const Json& use) {
  return find_schema(use, [](const Json& node) {
    return is_type(node, "array", {"array", "object", "string"});
  });
}

bool schema_accepts(const Json& scenario) { return checked_schema().accepts(scenario); }

std::string schema_fault(const Json& scenario) { return checked_schema().fault(scenario); }

Json json_of(const Node& node) {
  switch (node.kind) {
    case NodeKind::null:
      return nullptr;
    case NodeKind::scalar: {
      const PlainKind kind = node.quoted ? PlainKind::text : classify_plain(node.text);
      if (kind == PlainKind::boolean) return node.text == "true";
      if (kind != PlainKind::number) return node.text;
      const Json number = Json::parse(node.text, nullptr, false);
      return number.is_discarded() ? Json(std::stod(node.text)) : number;
    }
    case NodeKind::list: {
      Json list = Json::array();
      for (const Node& item : node.items) list.push_back(json_of(item));
      return list;
    }
    case NodeKind::map: {
      Json map = Json::object();
      for (std::size_t i = 0; i < node.items.size(); ++i) {
        map[node.keys[i].text] = json_of(node.items[i]);
      }
      return map;
    }
  }
  return {};
}

Json json_of(const std::string& yaml) {
  Faults faults;
  const auto tree = read_yaml_map(yaml, add_source(faults, "t.yaml"), faults);
  return tree ? json_of(*tree) : Json();
}

std::vector<std::string> docs_blocks(const std::string& language) {
  std::ifstream page(std::string(ENSONIFY_DOCS) + "/scenario.md");
  std::vector<std::string> found;
  bool inside = false;
  for (std::string line; std::getline(page, line);) {
    if (inside && line == "```") {
      inside = false;
    } else if (inside) {
      found.back() += line + "\n";
    } else if (line == "```" + language) {
      inside = true;
      found.emplace_back();
    }
  }
  return found;
}

// A scenario with a rig is read for one of its instruments.
static std::string for_first_instrument(const std::string& text) {
  const std::vector<std::string> names = instruments_in(text, {});
  return names.empty() ? text : text + "instrument: " + names.front() + "\n";
}

Samples::Samples() {
  for (const char* name : {"a.npy", "a.png", "a.obj", "a.tum", "a.csv", "a.vdb", "sand.csv",
                           "pulse.csv", "cast.csv"}) {
    folder_.write(name, "");
  }
  for (const char* name : {"meshes", "rigs"}) {
    fs::create_directory_symlink(fs::path(ENSONIFY_SCENES) / name, folder() / name);
  }
  texts_.assign(std::begin(kMore), std::end(kMore));
  for (const std::string& block : docs_blocks("yaml")) {
    const bool whole = block.starts_with("ensonify:");
    const bool has_sonar = block.starts_with("sonar:");
    texts_.push_back(whole       ? for_first_instrument(block)
                     : has_sonar ? "ensonify: 1\n" + block
                                 : kHead + block);
  }
  for (const auto& entry : fs::directory_iterator(ENSONIFY_SCENES)) {
    if (entry.path().extension() == ".yaml") texts_.push_back(read(entry.path()));
  }
  for (const auto& entry : fs::directory_iterator(fs::path(ENSONIFY_SCENES) / "rigs")) {
    if (entry.path().extension() != ".yaml") continue;
    std::string text = read(entry.path());
    const std::string mesh = "{file: ";
    const std::size_t at = text.find(mesh);
    if (at != std::string::npos) text.insert(at + mesh.size(), "rigs/");
    texts_.push_back(for_first_instrument(text));
  }
}

}  // namespace ensonify::testing
