// The fields of the sections of a scenario, and the checks that involve several keys.
//
//   fields            of each struct, in the file of its section
//   limits            that several sections share
//   preset_tree  preset_depends_on_range  number_in  blamed   presets.cpp, sonar.cpp
//   check_...         errors that show only when several sections are known
//   class_list  layer_target_words      from the tree before sampling
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/field_reader.h"
#include "scenario/scenario.h"

namespace ensonify {

inline constexpr NumberRange kPosition = from_to(-kMaxLengthM, kMaxLengthM);
inline constexpr NumberRange kAngle = above_up_to(0, 180);
inline constexpr int kMaxCount = 65534;  // of the instances that an entry stands for

void fields(Fields& f, Scenario& scenario);
void fields(Fields& f, SonarSpec& sonar);
void beam_fields(Fields& f, SonarSpec& sonar, Need need);
// Whether a kind of shading was read or written.
bool shading_fields(Fields& f, const KeyText& key, BeamShading& shading, Rule rule = {});
void receiver_fields(Fields& f, SonarSpec& sonar);
void transmit_fields(Fields& f, SonarSpec& sonar, Need need);  // the number of beams is known
void fields(Fields& f, ElectronicsSpec& electronics);
void fields(Fields& f, Detector& detector);
void fields(Fields& f, RecorderSpec& recorder);
void fields(Fields& f, CameraSpec& camera);
void fields(Fields& f, WaterSpec& water);
void fields(Fields& f, MaterialSpec& material);
// A random factor with mean 1, with the meanings of its keys.
struct TextureWords {
  std::string_view model, correlation;
  double shortest_m = 1e-3;      // correlation length
  double widest_spread_db = 20;  // of lognormal
};
void texture_fields(Fields& f, SurfaceTexture& texture, const TextureWords& words);
void fields(Fields& f, ObjectSpec& object);
void fields(Fields& f, ShapeSpec& shape);
void fields(Fields& f, HeightfieldSpec& field);
void cover_fields(Fields& f, HeightfieldSpec& field);  // stones, patches; the rest is known
void fields(Fields& f, PointTargetSpec& target);
void fields(Fields& f, VolumeSpec& volume);
void fields(Fields& f, PoseSpec& pose);
void fields(Fields& f, PlaceSpec& place);
void rotation_fields(Fields& f, RotationSpec& rotation, std::string_view meaning);
void fields(Fields& f, TrajectorySpec& trajectory);  // of an object: without pings
void sonar_trajectory_fields(Fields& f, TrajectorySpec& trajectory);
void fields(Fields& f, Navigation& navigation);
// Adds an error at shear_speed_m_s if no elastic solid has these wave speeds.
void check_solid(Fields& f, double speed_m_s, double shear_speed_m_s);
// Adds an error for a growth of no other material.
void check_growth(Fields& f, const std::vector<MaterialSpec>& materials);
void output_fields(Fields& f, Scenario& scenario);  // multipath is known
// Of `output.camera`: on by default where there is a camera, which is known.
void camera_output_fields(Fields& f, const Scenario& scenario, OutputSelection& selection);
void scene_file_fields(Fields& f, OutputSpec& output);  // of `output`

// The keys of a built-in preset, by its index in sonar_presets(). Where the preset lists rows under
// by_range_max_m, the keys of the row for the range_max_m of `sonar` (or for the preset's own, if
// `sonar` gives no number) replace those of the preset: that of the first row whose up_to_m is at
// least the range, or the last row.
Node preset_tree(std::size_t index, const Node& sonar);
bool preset_depends_on_range(std::size_t index);
// The number of a key; empty if the map has none.
std::optional<double> number_in(const Node& map, std::string_view key);

// Of two contradicting values, the one that the user wrote.
Value blamed(const Value& value, const Value& other);

// Keys of scattering and output that the receiver excludes.
void check_array(Faults& faults, const Value& root, const Scenario& scenario);
void check_transmit(Faults& faults, const Value& root, const Scenario& scenario);

// Checks that need both sonar and water: the size of a ping, and a burst longer than the record.
void check_ping_size(Faults& faults, const Value& root, const Scenario& scenario);
void check_burst_length(Faults& faults, const Value& root, const Scenario& scenario);
// A detector whose integration is longer than the record, or whose levels nothing has.
void check_detector(Faults& faults, const Value& root, const Scenario& scenario);

// Features that cannot be combined with a sound speed profile yet.
void check_profile_conflicts(Faults& faults, const Value& root, const Scenario& scenario);

// The objects that others are placed on must come before them, and so must all their parents.
void check_places(Faults& faults, const Value& root);

// Parents must be objects, in chains without a cycle.
void check_parents(Faults& faults, const Value& root);

// Names must be unique; ids and classes must fit into the masks.
void check_instances(Faults& faults, const Value& root);
// Refuses elastic objects whose material has a specular echo or a wall.
void check_elastic(Faults& faults, const Value& root, const Scenario& scenario);

// Every class that the lists name, including those in distributions, in order of appearance, with
// the default classes of entries without one. The kind is the one under `classes`; otherwise stuff
// if, in every sequence, only terrain, planes, rooms and volumes have the class. Errors: a key of
// `classes` that is not a class; a kind that is sampled.
struct ClassList {
  std::vector<std::string> names;
  std::vector<ClassKind> kinds;  // of each class
};
ClassList class_list(Faults& faults, const Value& root);
void class_fields(Fields& f, std::vector<ClassSpec>& classes);

// Valid names in output.layers.targets: objects, point targets and their classes, including those
// in distributions.
std::vector<std::string> layer_target_words(const Value& root);
void check_layer_targets(Faults& faults, const Value& root, const std::vector<std::string>& words);

}  // namespace ensonify
