// Reads a finished data set: the manifest, then one sequence and one ping at a time, so that memory
// does not grow with the data set. It opens no file outside the folder: names come from layout.h,
// numbers from the manifest, and links are not followed.
//
//   open_dataset     the classes and sequences
//   read_sequence    geometry, instances and kinds of files of one
//   for_each_ping    times, poses and masks, ping by ping
//   pictures_of      masks of a ping's images
//   stored_file      path of an existing file of a sequence
//   ping_file        ... of a ping's file
//
// Functions for further information about it:
//
//   read_facts           of the data set
//   read_sequence_facts  of a sequence: angles, numbers of its sonar, draws, instances
//   boxes_of             the 3-D boxes of some pings
//   read_statistics      an array of statistics/, with its real numbers
//
// Errors: (usage) not a data set of ensonify, or not finished; (io) a file is missing, unreadable,
// or does not match the manifests.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/vec.h"
#include "dataset/catalogue.h"
#include "dataset/manifest.h"

namespace ensonify {

using StoredSequenceRow = SequenceEntry;

struct StoredDataset {
  std::filesystem::path dir;
  DatasetManifest manifest;
  std::string name;
  std::vector<std::string> classes;    // class id k is classes[k - 1]
  std::vector<ClassKind> class_kinds;  // of each
  std::vector<StoredSequenceRow> sequences;
};

using StoredInstance = Instance;

struct StoredSequence {
  StoredSequenceRow row;
  SequenceManifest manifest;
  std::uint64_t seed = 0;
  std::uint64_t beams = 0, samples = 0;
  std::uint64_t elements = 0;                               // of an array; 0: none
  std::uint64_t cartesian_height = 0, cartesian_width = 0;  // 0: none
  std::uint64_t ray_elevations = 0, ray_azimuths = 0;       // of front views
  double metres_per_pixel = 0;
  double frequency_hz = 0, sound_speed_m_s = 0;
  double range_step_m = 0;   // from sample to sample
  double first_range_m = 0;  // of sample 0
  double beam_width_rad = 0, elevation_width_rad = 0;
  std::vector<StoredInstance> instances;  // by id - 1
  std::vector<std::string> each_ping;     // templates of layout.h
  bool packed = false;                    // output.one_file_per: sequence
  std::vector<std::string> arrays;        // ... then the files that hold all pings

  bool has(std::string_view name_template) const;
  bool has_array(std::string_view file) const;
  // Whether it has the row's file of each ping or its array.
  bool has(const CatalogueRow& row) const;
  GridSizes sizes() const;
};

struct StoredObjectPose {
  std::uint32_t instance = 0;
  Pose in_world;
};

struct StoredPing {
  std::uint32_t ping = 0;
  double time_s = 0;
  Pose sonar_in_world;
  std::vector<StoredObjectPose> objects;  // objects with a pose
  std::string annotation_line;            // of annotations.jsonl; see pictures_of
};

struct StoredAnnotation {
  std::uint16_t instance = 0;
  std::vector<std::int64_t> runs;   // of 0, 1, 0, ... down the columns; their sum is all pixels
  std::optional<double> occlusion;  // absent: not asked for, or no ray meets it
  std::optional<std::uint64_t> amodal_area;  // pixels; absent: not asked for
};

struct StoredPicture {
  std::string view;  // polar or cartesian
  std::uint64_t width = 0, height = 0;
  std::vector<StoredAnnotation> annotations;
  std::vector<std::uint16_t> hidden;  // fully hidden instances
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

struct DatasetFacts {
  std::string program;  // version and commit of the program that made it
  std::uint64_t seed = 0, bytes = 0;
  std::string scenario_sha256;
  std::string scenario;  // the text of scenario.yaml
};

struct InstanceFacts {
  std::string kind;  // surface, point_target or volume
  std::optional<Vec3> size_m;
  bool rough = false;  // a surface without coherent parts
};

struct SequenceFacts {
  std::vector<double> azimuth_rad;                         // of the beams
  double noise_power_pa2 = 0;                              // 0: none
  bool fresh_speckle = true;                               // each ping has its own draws
  std::optional<std::pair<double, double>> grey_db;        // black and white of its gray images
  std::vector<std::pair<std::string, double>> numbers;     // of sonar, water and noise, by name
  std::vector<std::pair<std::string, std::string>> draws;  // key path and value
  std::vector<InstanceFacts> instances;                    // by id - 1
  std::uint64_t realisations = 0;                          // of its statistics; 0: none
};

struct StoredBox {
  std::uint32_t ping = 0;
  std::uint16_t instance = 0;
  Vec3 size_m;
  Pose in_world;  // of its center
};

Result<DatasetFacts> read_facts(const StoredDataset& dataset);

Result<SequenceFacts> read_sequence_facts(const StoredDataset& dataset,
                                          const StoredSequence& sequence);

// In the order of the table; needs pings in rising order.
Result<std::vector<StoredBox>> boxes_of(const StoredDataset& dataset,
                                        const StoredSequence& sequence,
                                        std::span<const std::uint32_t> pings);

// statistics/NAME.npy of real numbers that has a value for each pixel, [samples x beams].
Result<std::vector<double>> read_statistics(const StoredDataset& dataset,
                                            const StoredSequence& sequence,
                                            const std::string& name);

}  // namespace ensonify
