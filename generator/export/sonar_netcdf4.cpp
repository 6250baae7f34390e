// SEQUENCE.nc: the complex time series of a sequence with the numbers of the sonar equation, in the
// layout of SONAR-netCDF4 2.0 (Macaulay and Peña, ICES Cooperative Research Report 341;
// github.com/ices-publications/SONAR-netCDF4). docs/export.md says what is missing.
#include <fmt/format.h>

#include <utility>

#include "dataset/layout.h"
#include "dataset/read_pictures.h"
#include "export/file_module.h"
#include "export/job.h"
#include "export/sonar_beam_group.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

void write_root(const ExportJob& job, NetcdfFile& file, const StoredSequence& sequence) {
  const std::pair<const char*, std::string> texts[] = {
      {"Conventions", "CF-1.7, SONAR-netCDF4-2.0, ACDD-1.3"},
      {"keywords", "simulated multibeam sonar"},
      {"sonar_convention_authority", "ICES"},
      {"sonar_convention_name", "SONAR-netCDF4"},
      {"sonar_convention_version", "2.0"},
      {"summary", fmt::format("Simulated pings of sequence {} of the data set {}, split {}",
                              sequence.row.sequence, job.dataset.name, sequence.row.split)},
      {"title", fmt::format("{}, sequence {}", job.dataset.name, sequence.row.sequence)}};
  for (const auto& [key, text] : texts) file.attribute("/", {key, text});
}

void write_environment(NetcdfFile& file, const SequenceInfo& info) {
  file.group("/Environment", {});
  const auto frequency = static_cast<float>(info.sonar.frequency_hz);
  const auto absorption = static_cast<float>(info.water.absorption_db_m);
  const auto speed = static_cast<float>(info.water.sound_speed_m_s);
  file.coordinate(
      {"/Environment/frequency",
       NetcdfType::f32,
       {},
       described("Acoustic frequency", "Hz",
                 {{"standard_name", std::string("sound_frequency")}, {"valid_min", 0.F}})},
      1);
  file.variable({"/Environment/absorption_indicative",
                 NetcdfType::f32,
                 {"/Environment/frequency"},
                 described("Indicative acoustic absorption", "dB/m", {{"valid_min", 0.F}})});
  file.variable({"/Environment/sound_speed_indicative",
                 NetcdfType::f32,
                 {},
                 described("Indicative sound speed", "m/s",
                           {{"standard_name", std::string("speed_of_sound_in_sea_water")},
                            {"valid_min", 0.F}})});
  file.write("/Environment/frequency", &frequency);
  file.write("/Environment/absorption_indicative", &absorption);
  file.write("/Environment/sound_speed_indicative", &speed);
}

void write_provenance(const ExportJob& job, NetcdfFile& file, const StoredSequence& sequence) {
  file.group("/Provenance",
             {{"conversion_software_name", std::string("ensonify")},
              {"conversion_software_version", job.dataset.manifest.identity.program_version}});
  file.dimension("/Provenance/filenames", sequence.row.pings());
  file.variable({"/Provenance/source_filenames",
                 NetcdfType::text,
                 {"/Provenance/filenames"},
                 {{"long_name", std::string("Source filenames")}}});
}

void make_platform(NetcdfFile& file, std::uint64_t pings) {
  file.group("/Platform", {{"platform_name", std::string("simulated")}});
  file.enumeration("/Platform/transducer_type_t",
                   {{"receive_only", 0}, {"transmit_only", 1}, {"monostatic", 3}});
  const std::pair<const char*, const char*> sensors[] = {{"transducer", "transducer_ids"},
                                                         {"position", "position_ids"},
                                                         {"MRU", "MRU_ids"},
                                                         {"gyro", "gyro_ids"}};
  for (const auto& [dimension, ids] : sensors) {
    const std::string length = std::string("/Platform/") + dimension;
    const std::string name = std::string("/Platform/") + ids;
    file.dimension(length, 1);
    file.variable({name, NetcdfType::text, {length}, {}});
    file.write_texts(name, {std::string(dimension) == "transducer" ? "sonar" : "pose"});
  }
  const std::string function = "/Platform/transducer_function";
  file.variable({function,
                 NetcdfType::named,
                 {"/Platform/transducer"},
                 {{"long_name", std::string("Transducer function")}},
                 "/Platform/transducer_type_t"});
  constexpr std::int8_t kMonostatic = 3;
  file.write(function, &kMonostatic);
  constexpr float kZero = 0;
  for (const char* part :
       {"offset_x", "offset_y", "offset_z", "rotation_x", "rotation_y", "rotation_z"}) {
    const std::string name = std::string("/Platform/transducer_") + part;
    const bool turns = part[0] == 'r';
    file.variable({name,
                   NetcdfType::f32,
                   {"/Platform/transducer"},
                   described(turns ? "Rotation from the transducer to the platform"
                                   : "Position of the transducer on the platform",
                             turns ? "arc_degree" : "m")});
    file.write(name, &kZero);
  }
  file.group("/Platform/Position", {});
  file.group("/Platform/Attitude", {});
  file.group("/Platform/Gyro", {});
  const std::pair<const char*, const char*> groups[] = {
      {kPositionGroup,
       "Position of the sonar in the world of the simulation, which has no latitude"},
      {kAttitudeGroup, "Attitude of the sonar"},
      {kGyroGroup, "Heading of the sonar; north is y of the world"}};
  for (const auto& [path, text] : groups) {
    file.group(path, {{"description", std::string(text)}});
    make_time_axis(file, path + std::string("/time"), "Timestamps of the pings", pings);
  }
}

Status with_series(const ExportJob& job, const StoredSequence& sequence) {
  if (has_series(sequence)) return {};
  return need(job, sequence, *find_file(FileScope::ping, layout::kTimeseries));
}

Status write_netcdf_sequence(const ExportJob& job, const fs::path& path,
                             const StoredSequence& sequence) {
  const Result<const FileModule*> module = file_module();
  if (!module) return module.error();
  const std::unique_ptr<NetcdfFile> opened((*module)->netcdf(path));
  NetcdfFile& file = *opened;
  write_root(job, file, sequence);
  write_environment(file, sequence.manifest.info);
  write_provenance(job, file, sequence);
  make_platform(file, sequence.row.pings());
  SonarBeamGroup beams(file, sequence);
  beams.make(job.dataset.manifest.identity.program_version);
  const std::string source =
      sequence.has(*find_file(FileScope::ping, layout::kTimeseries)) ? "npy" : "exr";
  std::uint64_t at = 0;
  const Status read = for_each_exported_ping(job, sequence, [&](const StoredPing& ping) -> Status {
    const auto time_ns = ping_ns(sequence, ping);
    if (!time_ns) return time_ns.error();
    file.write_text_at("/Provenance/source_filenames", at,
                       fmt::format("sequences/{:06}/timeseries/{:06}.{}", sequence.row.sequence,
                                   ping.ping, source));
    return beams.write(job, ping, at++, *time_ns);
  });
  const Status closed = file.close();
  return read ? closed : read;
}

}  // namespace

Status write_sonar_netcdf4(const ExportJob& job, const fs::path& target) {
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    if (const Status there = with_series(job, sequence); !there) return there;
    return write_netcdf_sequence(job, target / fmt::format("{:06}.nc", sequence.row.sequence),
                                 sequence);
  });
}

}  // namespace ensonify
