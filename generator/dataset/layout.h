// Where the files of a data set stand: every name is written here once, all relative to the data
// set's folder and with '/' between the parts.
//
//   sequence_folder  ping_stem  index_stem      sequences/000000   000003   000000/000003
//   ping_file        parse_ping_file            a template such as timeseries/{ping}.npy and back
//   record_path      plan_path                  what .work holds of a sequence
//   top_level_files  sequence_files             fixed names
//   is_layout_name                              could ensonify write a file (or folder) of this
//   name?
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ensonify::layout {

inline constexpr char kWorkJson[] = "work.json";
inline constexpr char kDatasetJson[] = "dataset.json";
inline constexpr char kDatasetSha256[] = "dataset.sha256";
inline constexpr char kProvenanceJson[] = "provenance.json";
inline constexpr char kSequenceJson[] = "sequence.json";
inline constexpr char kSdf[] = "sdf.vdb";  // where it is asked for
inline constexpr char kAnnotations[] = "annotations.jsonl";
// What statistics are made from while pings are missing; in .work.
inline constexpr char kMoments[] = "moments.bin";
inline constexpr char kWorkFolder[] = ".work";
inline constexpr char kTemporaryFolder[] = ".work/tmp";

// Files of a ping; {ping} stands for its stem.
inline constexpr char kTimeseries[] = "timeseries/{ping}.npy";
inline constexpr char kTimeseriesExr[] = "timeseries/{ping}.exr";
inline constexpr char kPolarExr[] = "polar/{ping}.exr";
inline constexpr char kPolarInstance[] = "polar/{ping}_instance.png";
inline constexpr char kPolarSemantic[] = "polar/{ping}_semantic.png";
inline constexpr char kPolarShadow[] = "polar/{ping}_shadow.png";
inline constexpr char kCartesianExr[] = "cartesian/{ping}.exr";
inline constexpr char kCartesianInstance[] = "cartesian/{ping}_instance.png";
inline constexpr char kCartesianSemantic[] = "cartesian/{ping}_semantic.png";
inline constexpr char kCartesianShadow[] = "cartesian/{ping}_shadow.png";
inline constexpr char kPolarMultipath[] = "polar/{ping}_multipath.png";
inline constexpr char kCartesianMultipath[] = "cartesian/{ping}_multipath.png";
inline constexpr char kPolarGrey[] = "png/{ping}_polar.png";
inline constexpr char kCartesianGrey[] = "png/{ping}_cartesian.png";
// Of a layer by its name (core/ping.h).
inline constexpr char kLayerPrefix[] = "layers/{ping}_";
inline constexpr char kChannels[] = "channels/{ping}.npy";
inline constexpr char kScatterers[] = "scatterers/{ping}.npy";
inline constexpr char kPoints[] = "points/{ping}.ply";

// A ping's part of arrays (packed.h), until the sequence is finished.
inline constexpr char kPieceFolder[] = "pieces";
inline constexpr char kPiece[] = "pieces/{ping}.bin";

// layers/{ping}_noise.npy
std::string layer_template(std::string_view layer);

std::string sequence_folder(std::uint32_t sequence);
std::string in_sequence(std::uint32_t sequence, std::string_view name);
std::string ping_stem(std::uint32_t ping);
std::string index_stem(std::uint32_t sequence, std::uint32_t ping);

// The name of a ping's file inside its sequence's folder.
std::string ping_file(std::string_view name_template, std::uint32_t ping);
// The opposite; none if the name is not of a ping.
struct PingFile {
  std::string name_template;
  std::uint32_t ping = 0;
};
std::optional<PingFile> parse_ping_file(std::string_view name);

std::string record_path(std::uint32_t sequence, std::uint32_t ping);
// What the sequence (the finishing step) is about to write; see overwrite.h.
std::string plan_path(std::uint32_t sequence);
std::string top_plan_path();

// Fixed names of the top level but for assets/; dataset.json, its hash and provenance.json
// included.
std::vector<std::string> top_level_files();
// Files that a sequence has once, sequence.json last.
std::vector<std::string> sequence_files();

// Whether a data set may hold a file or folder of this name: then it must not be a stranger's.
bool is_layout_name(std::string_view relative);

}  // namespace ensonify::layout
