// The sections of a scenario, each read into its struct; faults are added, what is right is kept.
//
//   parse_sonar                      with the preset it names
//   parse_water  parse_scattering  parse_trajectory  parse_output  parse_splits
//   parse_materials  parse_objects  parse_point_targets  check_instances
//   parse_pose  parse_input_file     shared by several
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
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

void parse_sonar(Faults& faults, const Value& value, SonarSpec& sonar);
void parse_water(Faults& faults, const Value& value, WaterSpec& water);

// What only shows when sonar and water are both known: the size of a ping.
void check_ping_size(Faults& faults, const Value& root, const Scenario& scenario);

void parse_scattering(Faults& faults, const Value& value, ScatteringSpec& scattering);
void parse_trajectory(const InputFolder& input, const Value& value, TrajectorySpec& trajectory);
void parse_output(Faults& faults, const Value& value, OutputSpec& output);
void parse_splits(Faults& faults, const Value& value, SplitsSpec& splits);

void parse_materials(Faults& faults, const Value& value, std::vector<MaterialSpec>& materials);
void parse_objects(const InputFolder& input, const Value& value,
                   const std::vector<MaterialSpec>& materials, std::vector<ObjectSpec>& objects);
void parse_point_targets(Faults& faults, const Value& value, std::vector<PointTargetSpec>& targets);

// Names told apart, ids and classes within what the masks can hold.
void check_instances(Faults& faults, const Value& root);

inline const std::vector<std::string_view> kPoseKeys = {"position_m", "rotation_deg",
                                                        "quaternion_wxyz"};

// The pose keys of a map that may hold others as well.
void parse_pose(Faults& faults, const Value& map, PoseSpec& pose);

// The file that `key` names, which must exist and end in one of `extensions` (".obj").
bool parse_input_file(const InputFolder& input, const Value& map, std::string_view key,
                      const std::vector<std::string_view>& extensions, std::filesystem::path& file);

}  // namespace ensonify
