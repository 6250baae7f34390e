// The sections of a scenario, each read into its struct; faults are added, what is right is kept.
//
//   parse_sonar  preset_trees        with the preset it names
//   parse_pulse  parse_beams  parse_receiver  parts of it, each in a file of its name
//   parse_water  parse_scattering  parse_trajectory  parse_output  parse_splits
//   parse_profile  check_profile_conflicts   in parse_profile.cpp
//   parse_materials                  laws and coherent parts, in parse_materials.cpp
//   parse_multipath  parse_multipath_mask   in parse_multipath.cpp
//   parse_objects  parse_point_targets  parse_volumes  check_instances
//   parse_shape                      in parse_shapes.cpp
//   MaterialNames  parse_material_name
//   parse_place  check_places        in parse_place.cpp
//   parse_heightfield                in parse_terrain.cpp
//   parse_pose  parse_input_file     shared by several
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "scenario/reader.h"
#include "scenario/scenario.h"

namespace ensonify {

// Where an input file is looked for, and what is told about it.
struct InputFolder {
  std::filesystem::path folder;
  Faults& faults;
};

// Metres: far beyond any sonar, near enough that squares stay exact.
inline constexpr double kMaxLengthM = 1e7;

inline constexpr NumberRange kLength = above_up_to(0, kMaxLengthM);
inline constexpr NumberRange kPosition = from_to(-kMaxLengthM, kMaxLengthM);
inline constexpr NumberRange kLevelDb = from_to(-300, 400);
inline constexpr NumberRange kAngle = above_up_to(0, 180);
inline constexpr NumberRange kLambertExponent = from_to(0, 100);

// The presets that are built in, read once for all scenarios; in the order of sonar_presets().
const std::vector<Node>& preset_trees();

void parse_sonar(const InputFolder& input, const Value& value, SonarSpec& sonar);
void parse_pulse(const InputFolder& input, const Value& sonar, PulseSpec& pulse);
void parse_beams(Faults& faults, const Value& beams, Need need, SonarSpec& sonar);
void parse_shading(Faults& faults, const Value& map, BeamShading& shading);  // its key `shading`
void parse_receiver(Faults& faults, const Value& receiver, SonarSpec& sonar);

// What does not go with the receiver, in scattering and output.
void check_array(Faults& faults, const Value& root, const Scenario& scenario);

// A chirp or burst against the bandwidth; `sonar_value` is merged with its preset.
void check_pulse_band(Faults& faults, const Value& sonar_value, const SonarSpec& sonar);

// Of two values that contradict each other, the one that the user wrote.
Value blamed(const Value& value, const Value& other);

void parse_profile(const InputFolder& input, const Value& value, ProfileSpec& profile);
void parse_water(const InputFolder& input, const Value& value, WaterSpec& water);

// What a sound speed profile cannot stand beside yet.
void check_profile_conflicts(Faults& faults, const Value& root, const Scenario& scenario);

// What only shows when sonar and water are both known: the size of a ping, a burst longer than the
// record.
void check_ping_size(Faults& faults, const Value& root, const Scenario& scenario);
void check_burst_length(Faults& faults, const Value& root, const Scenario& scenario);

void parse_scattering(Faults& faults, const Value& value, ScatteringSpec& scattering);
void parse_trajectory(const InputFolder& input, const Value& value, TrajectorySpec& trajectory);
void parse_object_trajectory(const InputFolder& input, const Value& value,
                             TrajectorySpec& trajectory);  // without pings
void parse_output(Faults& faults, const Value& value, OutputSpec& output);
void parse_png(Faults& faults, const Value& output, OutputSpec& spec);
void parse_layers(Faults& faults, const Value& output, OutputSpec& spec);
void parse_pack(Faults& faults, const Value& output, OutputSelection& selection);
// The last of them: without pings it takes away what the others ask for.
void parse_pings(Faults& faults, const Value& output, OutputSelection& selection);
void parse_timeseries(Faults& faults, const Value& output, OutputSelection& selection);

// What output.layers.targets may name: objects, point targets and their classes, behind draws too.
std::vector<std::string> layer_target_words(const Value& root);
void check_layer_targets(Faults& faults, const Value& root, const std::vector<std::string>& words);

void parse_multipath(Faults& faults, const Value& value, Multipath& multipath);
// output.multipath, when both are known: on where there are multipath and pictures.
void parse_multipath_mask(Faults& faults, const Value& root, Scenario& scenario);

void parse_splits(Faults& faults, const Value& value, SplitsSpec& splits);

void parse_materials(const InputFolder& input, const Value& value,
                     std::vector<MaterialSpec>& materials);
void parse_objects(const InputFolder& input, const Value& value,
                   const std::vector<MaterialSpec>& materials, std::vector<ObjectSpec>& objects);

// The materials that can be referred to, kept for the whole list of objects.
struct MaterialNames {
  std::unordered_set<std::string_view> set;
  std::vector<std::string_view> list;
};
// The name of one of them, which must be given.
void parse_material_name(Faults& faults, const Value& map, std::string_view key,
                         const MaterialNames& names, std::string& material);

void parse_shape(const InputFolder& input, const Value& map, const MaterialNames& names,
                 ShapeSpec& shape);
void parse_heightfield(const InputFolder& input, const Value& map, HeightfieldSpec& field);
void parse_point_targets(Faults& faults, const Value& value, std::vector<PointTargetSpec>& targets);
void parse_volumes(const InputFolder& input, const Value& value, std::vector<VolumeSpec>& volumes);

// Every class that the lists name, behind draws too, in order of appearance; with the defaults of
// those that name none.
std::vector<std::string> class_names(const Value& root);

// Names told apart, ids and classes within what the masks can hold.
void check_instances(Faults& faults, const Value& root);

inline const std::vector<std::string_view> kPoseKeys = {"position_m", "rotation_deg",
                                                        "quaternion_wxyz"};

void parse_place(Faults& faults, const Value& map, PlaceSpec& place);

// What objects are placed on: objects that stand before them.
void check_places(Faults& faults, const Value& objects);

// The pose keys of a map that may hold others as well.
void parse_pose(Faults& faults, const Value& map, PoseSpec& pose);

// The file that `key` names, which must exist and end in one of `extensions` (".obj").
bool parse_input_file(const InputFolder& input, const Value& map, std::string_view key,
                      const std::vector<std::string_view>& extensions, std::filesystem::path& file);

}  // namespace ensonify
