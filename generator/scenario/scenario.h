// A scenario as checked plain structs, in the units of its YAML keys (degrees stay degrees, so that
// writing the resolved scenario and reading it again changes no digit). The initial values are the
// defaults of keys that are left out; a key without a default is required.
//
//   load_scenario     file + overrides -> Scenario, or all errors together
//   check_draws       whether distributions stay within the valid values of their keys
//   to_yaml           Scenario -> the resolved text
//   sonar_preset_...  materials_yaml   the built-in presets
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/elastic.h"
#include "core/error.h"
#include "core/navigation.h"
#include "core/ping.h"
#include "core/random.h"
#include "core/surface.h"
#include "core/vec.h"
#include "scenario/camera_spec.h"
#include "scenario/faults.h"
#include "scenario/model_spec.h"
#include "scenario/path_spec.h"
#include "scenario/sonar_spec.h"
#include "scenario/terrain_spec.h"
#include "scenario/volume_spec.h"

namespace ensonify {

// An instrument of a rig. Exactly one of sonar, camera and navigation is required.
struct InstrumentSpec {
  std::string name;  // of its folder, too
  std::optional<SonarSpec> sonar;
  std::optional<CameraSpec> camera;
  std::optional<Navigation> navigation;
  std::optional<double> ping_rate_hz;  // absent: that of the trajectory
  double time_offset_s = 0;            // of its first ping, after the start of the trajectory
};

// Ocean water at the surface.
enum class AbsorptionModel { francois_garrison, ainslie_mccolm };

struct SeaAbsorptionSpec {
  AbsorptionModel model = AbsorptionModel::francois_garrison;
  double temperature_c = 10, salinity_psu = 35, ph = 8, depth_m = 0;
};
struct FixedAbsorptionSpec {
  double db_m = 0;
};

struct SoundSpeedSpec {
  double temperature_c = 0, salinity_psu = 0, depth_m = 0;
};

// From a file, or from rows.
struct ProfileSpec {
  std::filesystem::path file;  // CSV: depth_m, sound_speed_m_s
  std::vector<double> depth_m, sound_speed_m_s;
  double surface_z_m = 0;  // height in the world of depth 0
};

struct WaterSpec {
  double sound_speed_m_s = 1500;  // ignored if `from` below is set
  std::optional<SoundSpeedSpec> sound_speed_from;
  std::variant<SeaAbsorptionSpec, FixedAbsorptionSpec> absorption;
  std::optional<ProfileSpec> profile = {};  // absent: that sound speed everywhere
  double density_kg_m3 = 1025;
};

struct ScatteringSpec {
  double lambert_exponent = 1;
  Normalization normalization = Normalization::calibrated;
  SpeckleMode speckle = SpeckleMode::per_ping;
};

struct RicianSpec {
  double k = 0;
};
struct KirchhoffSpec {
  double reflection = 1;  // -1 ... 1
  double roughness_rms_m = 0;
  // None: the energy that roughness takes from the specular echo is lost.
  std::optional<double> roughness_correlation_m = std::nullopt;
  bool edges = false;
};
using CoherentSpec = std::variant<std::monostate, RicianSpec, KirchhoffSpec>;

// Patches of a surface on which another material has grown.
struct GrowthSpec {
  std::string material;
  double cover = 0;  // share of the surface
  double correlation_m = 0;
};

struct MaterialSpec {
  std::string name;
  double reflectivity = 0;  // required, unless the law states the strength itself
  ScatteringLaw law;        // without parameters that are left out
  CoherentSpec coherent;
  std::optional<SurfaceTexture> texture = {};
  std::optional<GrowthSpec> growth = {};
  std::optional<Wall> wall = {};
  Rgb color{0.5, 0.5, 0.5};  // share of the light that it reflects, for a camera
};

struct BoxSpec {
  std::array<double, 3> size_m{};
  bool inside = false;  // a room seen from inside
};
struct SphereSpec {
  double radius_m = 0;
  bool inside = false;
};
struct CylinderSpec {  // axis z, centered at the origin, closed by two discs
  double radius_m = 0, height_m = 0;
};
struct PlaneSpec {};  // z = 0, infinite
struct PartSpec {     // a named part of a mesh file with a material of its own
  std::string part, material;
};
struct MeshSpec {
  std::filesystem::path file;            // absolute or relative to the working directory
  std::array<double, 3> scale{1, 1, 1};  // for x, y and z
  bool smooth_normals = false;
  bool vertex_reflectivity = false;  // the material's reflectivity times the mesh's vertex colors
  std::vector<PartSpec> parts = {};  // other parts have the object's material
  std::filesystem::path texture_file = {};  // ... times this image; empty: none
};
// The zero surface of an OpenVDB level set.
struct LevelSetSpec {
  std::filesystem::path file;
  std::string grid;  // empty: the only grid of the file
  bool smooth_normals = true;
};
using ShapeSpec = std::variant<BoxSpec, SphereSpec, CylinderSpec, PlaneSpec, MeshSpec,
                               HeightfieldSpec, ModelSpec, LevelSetSpec>;

enum class ShellFilling { air, water };

// What an elastic body consists of: a metal, or else a material of its own.
struct ElasticSpec {
  std::optional<SphereMetal> metal = {};
  SphereMaterial material = {};
  std::optional<double> wall_m = {};  // absent: solid
  ShellFilling filling = ShellFilling::air;
};

// Name, material and shape are required.
struct ObjectSpec {
  std::string name;
  std::string class_name = "object";
  std::string material;
  ShapeSpec shape;
  PoseSpec pose;
  std::string parent = {};  // name of the object in whose frame `pose` is; empty: in the world
  std::optional<PlaceSpec> place = {};                      // if given, replaces `pose`
  std::optional<TrajectorySpec> trajectory = std::nullopt;  // replaces the pose
  std::optional<ElasticSpec> elastic = std::nullopt;        // of a sphere or cylinder
};

struct RingingSphereSpec : ElasticSpec {
  double radius_m = 0;
};

// Name and position are required.
struct PointTargetSpec {
  std::string name;
  std::string class_name = "point_target";
  double target_strength_db = 0;
  std::array<double, 3> position_m{};
  std::optional<RingingSphereSpec> sphere = {};  // in place of the target strength
};

struct ClassSpec {
  std::string name;
  ClassKind kind = ClassKind::thing;
};

struct OutputSpec {
  // shadow and amodal: on with polar or Cartesian images; multipath: if the scenario also has
  // multipath.
  OutputSelection selection;
  int cartesian_height_px = 1000;
  double elevation_step_deg = 0.5;
  std::optional<std::array<double, 2>> png_db;  // absent: from a few pings of the data set
  Display png;                                  // without its limits
  // Names and classes of the layer `target`; absent: everything finite that is not inward facing.
  std::optional<std::vector<std::string>> layer_targets;
  std::optional<SdfGrid> sdf = {};           // absent: no file is written
  std::optional<HeightMap> height_map = {};  // only its spacing; absent: no file is written
};

// Relative shares. If `splits` is given, a share left out is 0.
struct SplitsSpec {
  double train = 1, val = 0, test = 0;
};

// What catalogs of data sets ask for. All empty: not stated.
struct DatasetSpec {
  std::string license, creator, citation, url;
  std::string published;  // the day, YYYY-MM-DD
};

struct DrawnSections;  // private to scenario/

struct Scenario {
  std::string name;  // absent: the file's name without its ending
  std::uint64_t seed = 0;
  std::optional<std::uint64_t> speckle_seed;  // absent: the speckle follows from the seed alone
  std::uint32_t sequences = 1;
  // With a rig these are those of `instrument`; that of an instrument without one hears nothing.
  SonarSpec sonar;
  std::vector<InstrumentSpec> rig;   // empty: one sonar
  std::string instrument;            // the one of the rig that the scenario was read for
  std::optional<CameraSpec> camera;  // absent: none
  WaterSpec water;
  ScatteringSpec scattering;
  std::vector<MaterialSpec> materials;
  std::vector<ObjectSpec> objects;
  std::vector<PointTargetSpec> point_targets;
  std::vector<VolumeSpec> volumes;
  std::vector<ClassSpec> classes;      // the classes whose kind the text states
  std::optional<Multipath> multipath;  // absent: direct echoes only
  int bounces = 0;  // surfaces beyond the first one on a path, of any shape; not with multipath
  TrajectorySpec trajectory;
  bool motion_within_ping = false;
  std::optional<Navigation> navigation = {};      // absent: no sensors
  std::optional<double> noise_spectrum_level_db;  // one of these, or neither
  std::optional<double> noise_snr_db;
  bool noise_correlated = false;      // between beams
  double synthesis_tolerance = 1e-5;  // relative L2 error of the time series
  OutputSpec output;
  OutputSpec rig_output = {};  // with a rig: as stated; `output` has what `instrument` makes of it
  SplitsSpec splits;
  DatasetSpec dataset;
  // Every class that any sequence can have, in the order of the file, so that ids are the same in
  // all sequences.
  std::vector<std::string> class_names;
  std::vector<ClassKind> class_kinds;  // of each class
  bool has_draws = false;         // something is sampled or placed: sequences are different worlds
  std::uint32_t redraw = 0;       // of the SequenceDraw that it was sampled for
  std::vector<DrawnValue> draws;  // of this sequence, sorted by path
  std::shared_ptr<const DrawnSections> drawn_sections;  // the text that to_yaml writes for them
  // To report without an error: files from outside its folder, and those of the sonar.
  std::vector<std::string> notices;
};

// One `--set KEY.PATH=VALUE`.
struct Override {
  std::string path;
  std::string value;  // read as YAML
};

// Reads, merges presets and overrides, fills in defaults, checks everything, samples distributions
// for `draw` (keyed by the seed) and expands counts. Errors (usage): one line per error,
// `file:line:column: key.path: what is wrong; expected what would be right`, for all errors of the
// file together, including input files that do not exist. A scenario file that exists but cannot be
// opened or read is an io error.
Result<Scenario> load_scenario(const std::filesystem::path& file,
                               const std::vector<Override>& overrides = {}, SequenceDraw draw = {});

// An error about a value that is found only when files, sizes and poses are combined, `key.path:
// ...`, with the place of that key in the text, or of what surrounds it there, before it. Unchanged
// if the text has no part of the path or an override gives the value.
Error with_place(const Error& error, const std::string& text, const std::string& label,
                 const std::vector<Override>& overrides = {});

// Used in place of the name of a scenario file.
inline constexpr const char* kStandardInput = "-";

// The text of a scenario file, or of standard input, which can be read only once. Errors as above,
// for the file only; `what` names the expected content.
Result<std::string> read_scenario_text(const std::filesystem::path& file,
                                       std::string_view what = "a scenario");

// The same for a text; relative paths in it are relative to `folder`; `label` is the file name in
// messages.
Result<Scenario> parse_scenario(const std::string& text, const std::string& label,
                                const std::filesystem::path& folder,
                                const std::vector<Override>& overrides = {}, SequenceDraw draw = {},
                                const ReadLimits& limits = {},
                                ErrorPlaces places = ErrorPlaces::shown);

// Checks that the extremes of distributions (draw_extremes) and every alternative are valid values
// of their keys; values in between are not checked. Errors: as parse_scenario, but only those at or
// inside a distribution; the rest of the text has been checked.
Status check_draws(const std::string& text, const std::string& label,
                   const std::filesystem::path& folder,
                   const std::vector<Override>& overrides = {});

// The second step of parse_scenario, after the overrides, for callers that make many scenarios from
// one text. Empty if `faults` has any errors, older ones included. `label` names a scenario without
// a name.
struct Node;
std::optional<Scenario> parse_scenario_tree(Node tree, const std::string& label,
                                            const std::filesystem::path& folder, Faults& faults,
                                            SequenceDraw draw = {});
// The same step of check_draws.
void check_draws(const Node& tree, const std::string& label, const std::filesystem::path& folder,
                 Faults& faults);

// The resolved scenario: every key with its value, presets expanded, in a fixed order, numbers in
// the shortest form that reads back to the same double. `name_file` returns the name of an input
// file in the text (a data set names its assets by hash). A section with distributions or counts
// keeps them, so that the text is the same for every sequence and samples the same values again.
std::string to_yaml(const Scenario& scenario,
                    const std::function<std::string(const std::filesystem::path&)>& name_file);

// Whether sequences differ in more than speckle and noise.
bool varies_by_sequence(const Scenario& scenario);

// Input files that the scenario names (tables, meshes, paths), without repetition, in order of
// appearance; for a section with distributions, every file that some sequence may use.
std::vector<std::filesystem::path> input_files(const Scenario& scenario);

// The sonar as the stages need it, in SI units and radians. Tables are not read: sonar.pulse.table
// and tables of materials are empty, and sonar.array is absent (ping/array_receiver.h).
Sonar sonar_of(const Scenario& scenario);
Material material_of(const MaterialSpec& spec, const ScatteringSpec& scattering);

// Whether a material is a wall that sound passes through.
bool has_walls(const Scenario& scenario);
// Whether there are paths other than the direct one: with multipath, bounces or walls.
bool has_more_paths(const Scenario& scenario);

struct SonarPreset {
  std::string name;
  std::string description;  // the comment lines at the head of its file
  std::string yaml;
};

// The presets of configs/sonars, built into the program and sorted by name.
const std::vector<SonarPreset>& sonar_presets();
// The materials that a scenario may name, with their sources: configs/materials.yaml.
std::string_view materials_yaml();

}  // namespace ensonify
