// A finished data set, read again: the manifest, then one sequence and one ping at a time, so that
// memory does not grow with the data set. Nothing outside its folder is ever opened: names come
// from layout.h, numbers from the manifest, and links are not followed.
//
//   open_dataset     which classes and sequences there are
//   read_sequence    geometry, instances and kinds of files of one
//   for_each_ping    times, poses and masks, ping by ping
//   pictures_of      masks of a ping's pictures
//   stored_file      path of a sequence's file that is there
//   ping_file        ... of a ping's file
//   damaged          the Error for a file that is not as it should be
//
// Errors: (usage) not a data set of ensonify, or not finished; (io) a file is missing, cannot be
// read or is not as the manifests say.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/vec.h"

namespace ensonify {

struct StoredSequenceRow {
  std::uint32_t sequence = 0;
  std::string split;                            // train, val or test
  std::uint32_t first_ping = 0, last_ping = 0;  // [first, last)
  std::string sha256;                           // of its sequence.json

  std::uint64_t pings() const { return std::uint64_t{last_ping} - first_ping; }
};

struct StoredDataset {
  std::filesystem::path dir;
  std::string name;
  std::vector<std::string> classes;  // class id k is classes[k - 1]
  std::vector<StoredSequenceRow> sequences;
};

struct StoredInstance {
  std::uint16_t id = 0;
  std::uint8_t class_id = 0;
  std::string name;
};

struct StoredSequence {
  StoredSequenceRow row;
  std::uint64_t seed = 0;
  std::uint64_t beams = 0, samples = 0;
  std::uint64_t cartesian_height = 0, cartesian_width = 0;  // 0: none
  double metres_per_pixel = 0;
  double frequency_hz = 0, sound_speed_m_s = 0;
  double range_step_m = 0;  // from sample to sample
  double beam_width_rad = 0, elevation_width_rad = 0;
  std::vector<StoredInstance> instances;  // by id - 1
  std::vector<std::string> each_ping;     // templates of layout.h
  bool packed = false;                    // output.pack: sequence
  std::vector<std::string> arrays;        // ... then the files that hold all pings

  bool has(std::string_view name_template) const;
  bool has_array(std::string_view file) const;
};

struct StoredObjectPose {
  std::uint32_t instance = 0;
  Pose in_world;
};

struct StoredPing {
  std::uint32_t ping = 0;
  double time_s = 0;
  Pose sonar_in_world;
  std::vector<StoredObjectPose> objects;  // those with a place of their own
  std::string annotation_line;            // of annotations.jsonl; see pictures_of
};

struct StoredAnnotation {
  std::uint16_t instance = 0;
  std::vector<std::int64_t> runs;   // of 0, 1, 0, ... down the columns; they add to all pixels
  std::optional<double> occlusion;  // absent: not asked for, or no ray meets it
};

struct StoredPicture {
  std::string view;  // polar or cartesian
  std::uint64_t width = 0, height = 0;
  std::vector<StoredAnnotation> annotations;
  std::vector<std::uint16_t> hidden;  // instances that others hide wholly
};

Result<StoredDataset> open_dataset(const std::filesystem::path& dir);

Result<StoredSequence> read_sequence(const StoredDataset& dataset, const StoredSequenceRow& row);

// In order; ends with the first Error of `use`.
Status for_each_ping(const StoredDataset& dataset, const StoredSequence& sequence,
                     const std::function<Status(const StoredPing&)>& use);

Result<std::vector<StoredPicture>> pictures_of(const StoredDataset& dataset,
                                               const StoredSequence& sequence,
                                               const StoredPing& ping);

Result<std::filesystem::path> stored_file(const StoredDataset& dataset, std::uint32_t sequence,
                                          std::string_view name);
Result<std::filesystem::path> ping_file(const StoredDataset& dataset, std::uint32_t sequence,
                                        std::string_view name_template, std::uint32_t ping);

Error damaged(const std::filesystem::path& path, const std::string& what);

}  // namespace ensonify
