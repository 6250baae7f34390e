// What the files of a data set tell beside what read_dataset.h takes from them: whatever a person
// wants to read about it.
//
//   read_facts           of the data set
//   read_sequence_facts  of a sequence: angles, numbers of its sonar, draws, instances
//   boxes_of             the 3-D boxes of some pings
//   read_statistics      an array of statistics/, with its real numbers
//
// Errors: (io) a file is missing, cannot be read or is not as the manifests say.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/vec.h"
#include "dataset/read_dataset.h"

namespace ensonify {

struct DatasetFacts {
  std::string program;  // version and commit of the program that made it
  std::uint64_t seed = 0, bytes = 0;
  std::string scenario_sha256;
  std::string scenario;  // the text of scenario.yaml
};

struct InstanceFacts {
  std::string kind;  // surface, point_target or volume
  std::optional<Vec3> size_m;
  bool rough = false;  // a surface, no part of which throws anything back coherently
};

struct SequenceFacts {
  std::vector<double> azimuth_rad;                         // of the beams
  double noise_power_pa2 = 0;                              // 0: none
  bool fresh_speckle = true;                               // each ping has draws of its own
  std::optional<std::pair<double, double>> grey_db;        // black and white of its grey pictures
  std::vector<std::pair<std::string, double>> numbers;     // of sonar, water and noise, by name
  std::vector<std::pair<std::string, std::string>> draws;  // key path and value
  std::vector<InstanceFacts> instances;                    // by id - 1
  std::uint64_t realisations = 0;                          // of its statistics; 0: none
};

struct StoredBox {
  std::uint32_t ping = 0;
  std::uint16_t instance = 0;
  Vec3 size_m;
  Pose in_world;  // of its centre
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
