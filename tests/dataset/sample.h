// A small data set with every kind of file in it, for the tests of dataset/.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/image_planes.h"
#include "core/parallel.h"
#include "core/ping.h"
#include "dataset/finish.h"
#include "dataset/work.h"
#include "temporary_folder.h"

namespace ensonify::sample {

using test::TemporaryFolder;

constexpr int kBeams = 6, kSamples = 9, kPings = 3;

SequenceInfo sequence_info(std::uint32_t sequence);
// With the planes that a scenario gets which asks for none.
LabelledImage image(int rows, int columns, int variant, const OutputSelection& output = {});
bool has_plane(const OutputSelection& output, const ImagePlane& plane);
PingResult ping_result(const SequenceInfo& info, std::uint32_t ping);
WorkIdentity identity();
DatasetInfo dataset_info(std::uint32_t sequences);

// Of a Cartesian image; nothing says that it is that of a fan.
std::vector<std::int32_t> cartesian_map(const SequenceInfo& info);
// With that map.
Status finish(const std::filesystem::path& dir, const SequenceInfo& info);

// The steps of a run; they require success.
void open(const std::filesystem::path& dir, std::uint32_t sequences);
void write_pings(const std::filesystem::path& dir, const SequenceInfo& info);
void make_dataset(const std::filesystem::path& dir, std::uint32_t sequences);

// Every file's bytes by relative path, but for provenance.json.
std::map<std::string, std::string> contents(const std::filesystem::path& dir);

std::string read(const std::filesystem::path& file);
void write(const std::filesystem::path& file, const std::string& bytes);
void flip_bit(const std::filesystem::path& file, std::size_t byte, int bit);

}  // namespace ensonify::sample
