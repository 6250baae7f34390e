// Paths of the files of a data set, relative to its folder, with '/' between the parts; catalogue.h
// lists them all.
//
//   sequence_folder  ping_stem  index_stem      sequences/000000   000003   000000/000003
//   ping_file        parse_ping_file            a template such as timeseries/{ping}.npy and back
//   record_path  plan_path  failure_path        files of a sequence in .work
//   is_layout_name                              whether ensonify could write a file of this name
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/files.h"

namespace ensonify::layout {

inline constexpr char kWorkJson[] = "work.json";
inline constexpr char kDatasetJson[] = "dataset.json";
inline constexpr char kDatasetSha256[] = "dataset.sha256";
inline constexpr char kProvenanceJson[] = "provenance.json";
inline constexpr char kCroissantJson[] = "croissant.json";
inline constexpr char kRigJson[] = "rig.json";  // above the data sets of a rig
inline constexpr char kSequenceJson[] = "sequence.json";
inline constexpr char kCovisibility[] = "covisibility.npy";  // where it is asked for
inline constexpr char kSdf[] = "sdf.vdb";                    // where it is asked for
inline constexpr char kWorldPly[] = "world.ply";             // where they are asked for
inline constexpr char kWorldGlb[] = "world.glb";
inline constexpr char kHeightMap[] = "height_map.npy";                 // where it is asked for
inline constexpr char kCartesianMap[] = "cartesian_map.npy";           // with Cartesian images
inline constexpr char kFrontElevations[] = "front_elevation_rad.npy";  // with front views
inline constexpr char kFrontAzimuths[] = "front_azimuth_rad.npy";
inline constexpr char kAnnotations[] = "annotations.jsonl";
// Moments for the statistics while pings are missing; in .work.
inline constexpr char kMoments[] = "moments.bin";
inline constexpr char kWorkFolder[] = ".work";
inline constexpr char kRenders[] = "renders";  // of `ensonify render`, a folder each
inline constexpr char kRenderJson[] = "render.json";
inline constexpr std::array kSplits = {"train", "val", "test"};
using ensonify::kTemporaryFolder;

// Files of a ping that the code refers to; catalogue.h has all. {ping} stands for the ping's stem.
inline constexpr char kTimeseries[] = "timeseries/{ping}.npy";
inline constexpr char kTimeseriesExr[] = "timeseries/{ping}.exr";
inline constexpr char kPolarExr[] = "polar/{ping}.exr";
inline constexpr char kPolarGrey[] = "png/{ping}_polar.png";
inline constexpr char kCartesianGrey[] = "png/{ping}_cartesian.png";
inline constexpr char kChannels[] = "channels/{ping}.npy";
inline constexpr char kScatterers[] = "scatterers/{ping}.npy";
inline constexpr char kScattererVia[] = "scatterers/{ping}_via.npy";
inline constexpr char kElevation[] = "elevation/{ping}.npy";
inline constexpr char kBeamPower[] = "beam_power.npy";
inline constexpr char kPulsePower[] = "pulse_power.npy";
inline constexpr char kRecorded8[] = "recorded/{ping}_8bit.png";
inline constexpr char kRecorded16[] = "recorded/{ping}_16bit.png";
inline constexpr char kRecordedRowGain[] = "recorded/{ping}_row_gain.npy";
inline constexpr char kFrontExr[] = "front/{ping}.exr";
inline constexpr char kPoints[] = "points/{ping}.ply";

// A ping's part of arrays (packed.h), until the sequence is finished.
inline constexpr char kPieceFolder[] = "pieces";
inline constexpr char kPiece[] = "pieces/{ping}.bin";

std::string sequence_folder(std::uint32_t sequence);
std::string in_sequence(std::uint32_t sequence, std::string_view name);
std::string ping_stem(std::uint32_t ping);
std::string index_stem(std::uint32_t sequence, std::uint32_t ping);

// The name of a ping's file inside its sequence's folder.
std::string ping_file(std::string_view name_template, std::uint32_t ping);
// The inverse of ping_file; none if the name is not that of a ping's file.
struct PingFile {
  std::string name_template;
  std::uint32_t ping = 0;
};
std::optional<PingFile> parse_ping_file(std::string_view name);

std::string record_path(std::uint32_t sequence, std::uint32_t ping);
// Files that the sequence (the finishing step) will write; see overwrite.h.
std::string plan_path(std::uint32_t sequence);
// The file with the reason why the sequence cannot be made; see work_folder.h.
std::string failure_path(std::uint32_t sequence);
std::string top_plan_path();

// Whether a data set may hold a file or folder of this name, so that no foreign file may have it.
bool is_layout_name(std::string_view relative);

}  // namespace ensonify::layout
