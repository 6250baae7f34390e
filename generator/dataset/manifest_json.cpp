#include "dataset/manifest_json.h"

#include <algorithm>

#include "core/navigation_keys.h"
#include "core/navigation_tables.h"
#include "dataset/catalogue.h"
#include "dataset/layout.h"
#include "dataset/manifest_camera.h"
#include "dataset/manifest_members.h"
#include "dataset/member_schema.h"
#include "dataset/statistics.h"

namespace ensonify {

namespace {

template <class Io, class Info>
void water_members(Io& io, Info& info) {
  auto& water = info.water;
  io("sound_speed_m_s", water.sound_speed_m_s);
  if (info.recording) return;
  if (is_sonar(info)) {
    io("absorption_db_m", water.absorption_db_m);
    io.sometimes(!water.group_absorption_db_m.empty(), "group_absorption_db_m",
                 water.group_absorption_db_m);
  }
  io.maybe("profile", water.profile, [](Io& rows, auto& profile) {
    rows("surface_z_m", profile.surface_z_m);
    rows("depth_m", profile.depth_m);
    rows("sound_speed_m_s", profile.speed_m_s);
  });
  io.sometimes(water.density_kg_m3 != Water{}.density_kg_m3, "density_kg_m3", water.density_kg_m3);
}

template <class Io, class Info>
void record_members(Io& io, Info& info) {
  io("samples", info.record.samples);
  if (!info.recording) {
    io("transform", info.record.transform);
    io("pulse_extent_s", info.pulse_extent_s);
  }
  io("sample_interval_s", info.record.sample_interval_s);
  io.said("range_step_m", range_step_m(info.sonar, info.water));
  if (info.recording) io("first_range_m", info.sonar.first_range_m);
}

template <class Io, class Value>
void recording_members(Io& io, Value& recording) {
  io("format", recording.format);
  io("file", recording.file);
  io("sha256", recording.sha256);
  io("instrument", recording.instrument);
  io("serial", recording.serial);
  io("mode", recording.mode);
  io("first_frame", recording.first_frame);
  io("start_us", recording.start_us);
}

template <class Io, class Info>
void noise_members(Io& io, Info& info) {
  io("spectrum_level_db", info.noise_spectrum_level_db);
  io("snr_db", info.noise_snr_db);
  io("power_pa2", info.noise_power_pa2);
  io.sometimes(info.noise_correlated, "correlated", info.noise_correlated);
}

// Everything that turns the level Y of the EXR file into the 8-bit value.
template <class Io, class Info>
void png_members(Io& io, Info& info) {
  display_members(io, info.png, info.png_counts, info.water.absorption_db_m);
  io.together_if(!is_plain(info.png), [&](Io& also) {
    also.said("formula", grey_formula(info.png, "tvg.absorption_db_m"));
  });
}

template <class Io, class Value>
void cartesian_members(Io& io, Value& grid) {
  io("height_px", grid.height_px);
  io("width_px", grid.width_px);
  io("metres_per_pixel", grid.m_per_px);
  io("x_top_m", grid.x_top_m);
  io("y_left_m", grid.y_left_m);
  io.said("pixel_centre",
          "x = x_top_m - (row + 0.5) metres_per_pixel, y = y_left_m - (column + 0.5) "
          "metres_per_pixel; x along the boresight, y to port");
}

template <class Io, class Value>
void elevation_members(Io& io, Value& output) {
  io("step_rad", output.elevation_step_rad);
  io("volumes", output.elevation_volumes);
}

template <class Io, class Value>
void sdf_members(Io& io, Value& sdf) {
  io.said("file", layout::kSdf);
  io.said("grid", "sdf");
  io("voxel_m", sdf.voxel_m);
  io("band_voxels", sdf.band_voxels);
  io.said("frame", "world, at the first ping; the center of voxel i is at i voxel_m; meters");
  io.said("sign", "negative inside solids; beyond the band +- band_voxels voxel_m");
}

template <class Io, class Value>
void height_map_members(Io& io, Value& map) {
  io.said("file", layout::kHeightMap);
  io("spacing_m", map.spacing_m);
  io("rows", map.rows);
  io("columns", map.columns);
  io("x_west_m", map.x_west_m);
  io("y_north_m", map.y_north_m);
  io.said("point",
          "x = x_west_m + column spacing_m, y = y_north_m - row spacing_m; world, at the first "
          "ping");
}

template <class Io, class Value>
void navigation_members(Io& io, Value& navigation) {
  io.said("gravity_m_s2", kGravityMS2);
  io.group("sonar_in_body", [&](Io& sonar) {
    sonar("position_m", navigation.sonar_in_body.position_m);
    sonar("quaternion_wxyz", navigation.sonar_in_body.rotation);
  });
  navigation_keys(io, navigation.sensors);
}

template <class Io>
void world_members(Io& io) {
  io.said("ply", layout::kWorldPly);
  io.said("glb", layout::kWorldGlb);
  io.said("frame", "ply: world; glb: y up, (x, z, -y) of the world; at the first ping; meters");
  io.said("chord_of_radius", kChordOfRadius);
}

template <class Io, class Value>
void multipath_members(Io& io, Value& multipath) {
  const auto flat = [](Io& surface, auto& values) {
    surface("z_m", values.z_m);
    surface("reflection", values.reflection);
    surface("roughness_rms_m", values.roughness_rms_m);
  };
  io.optional("surface", multipath.surface, flat);
  io.optional("bottom", multipath.bottom, flat);
  io("objects", multipath.objects);
  io("bounces", multipath.bounces);
}

template <class Io, class Value>
void path_members(Io& io, Value& path) {
  io("id", path.id);
  io("out", path.out);
  io("back", path.back);
}

// The content of each layer.
template <class Io, class Info>
void layer_members(Io& io, Info& info) {
  for (int i = 0; i <= static_cast<int>(Layer::electronics); ++i) {
    const auto layer = static_cast<Layer>(i);
    bool is_there = std::ranges::find(info.layers, layer) != info.layers.end();
    io.flag(layer_name(layer), is_there, [&](Io& about) {
      if constexpr (Io::kReads) info.layers.push_back(layer);
      if (layer == Layer::target) about("instances", info.target_instances);
    });
  }
}

template <class Io, class Value>
void placement_members(Io& io, Value& placement) {
  io("redraws", placement.redraws);
  io.list("classes", placement.classes,
          [](Io& item, auto& placed) { placed_class_members(item, placed); });
  io("left_out", placement.left_out);
}

// Sampled values; numbers stay numbers, and everything else is YAML text.
Json draws_json(const std::vector<DrawnValue>& draws) {
  Json json = Json::object();
  for (const DrawnValue& draw : draws) {
    const auto value = parse_json(draw.value);
    json[draw.path] = value && value->is_number() ? *value : Json(draw.value);
  }
  return json;
}

void read_draws(MemberReader& io, SequenceInfo& info) {
  io.group("draws", [&](MemberReader& draws) {
    for (const auto& [path, value] : draws.json().items()) {
      info.draws.push_back({path, value.is_string() ? value.get<std::string>() : value.dump()});
    }
  });
}

// Shapes of the arrays that hold all pings; null where each ping has files.
Json arrays_json(const SequenceInfo& info) {
  if (!info.output.packed) return nullptr;
  Json json = Json::object();
  const GridSizes sizes = sizes_of(info);
  for (const CatalogueRow* array : arrays_of(selection_of(info))) {
    json[array->array] = {{"dtype", array->type.substr(1, array->type.size() - 2)},
                          {"shape", array_shape(*array, sizes)}};
  }
  return json;
}

// Members between the numbers of the sequence and its instances.
template <class Io, class Info>
void number_members(Io& io, Info& info) {
  io("sequence", info.sequence);
  io.sometimes(!is_sonar(info), "instrument", info.instrument);
  // Read first, since a recording lacks members that the model of a simulation has.
  io.maybe("recording", info.recording,
           [](Io& recording, auto& value) { recording_members(recording, value); });
  io("seed", info.seed);
  io.sometimes(info.speckle_seed.has_value(), "speckle_seed", info.speckle_seed);
  io.sometimes(info.instrument_seed.has_value(), "instrument_seed", info.instrument_seed);
  io("split", info.split);
  io.pings(info.first_ping, info.last_ping);
  io.maybe("mount", info.mount, [](Io& mount, auto& pose) {
    mount("position_m", pose.position_m);
    mount("quaternion_wxyz", pose.rotation);
  });
  if (!is_sonar(info)) {
    return io.group("water", [&](Io& water) { water_members(water, info); });
  }
  io.group("sonar", [&](Io& sonar) { sonar_members(sonar, info); });
  io.maybe("recorder", info.recorder,
           [](Io& recorder, auto& values) { recorder_members(recorder, values); });
  io.group("water", [&](Io& water) { water_members(water, info); });
  io.group("record", [&](Io& record) { record_members(record, info); });
  if (info.recording) return;
  io.group("scattering",
           [&](Io& scattering) { scattering.word("speckle", info.speckle, SpeckleMode::surface); });
  io.group_if("noise", info.noise_power_pa2 > 0, [&](Io& noise) { noise_members(noise, info); });
  io.group("synthesis", [&](Io& synthesis) { synthesis("tolerance", info.synthesis_tolerance); });
}

// What a written sequence.json needs of a SequenceManifest.
struct WrittenHead {
  const SequenceInfo& info;
  const std::vector<std::string>& each_ping;
  const std::uint64_t& bytes;
};

// What follows from the outputs of the sequence. A reader takes the outputs from it.
template <class Io, class Manifest>
void listing_members(Io& io, Manifest& manifest) {
  auto& info = manifest.info;
  io.said("axes", axes_json(info));
  io.said("pack", info.output.packed ? "sequence" : "ping");
  io.said("arrays", arrays_json(info));
  if constexpr (Io::kReads) {
    info.output.packed = text_at(io.json(), "pack") == "sequence";
    io.group("axes", [&](Io& axes) { info.output.front = axes.json().contains("front"); });
    io.group("arrays", [&](Io& arrays) {
      manifest.has_arrays = true;
      for (const auto& array : arrays.json().items()) manifest.arrays.push_back(array.key());
    });
  }
  io("each_ping", manifest.each_ping);
  io("bytes", manifest.bytes);
}

template <class Io, class Manifest>
void statistics_member(Io& io, Manifest& manifest) {
  auto& info = manifest.info;
  auto& output = info.output;
  if constexpr (Io::kReads) {
    io.flag("statistics", output.statistics, [&](Io& statistics) {
      statistics("realisations", manifest.realisations);
      // Earlier versions have none of these.
      const Json& json = statistics.json();
      info.scene_sha256 = text_at(json, "scene_sha256").value_or("");
      info.scenario_sha256 = text_at(json, "scenario_sha256").value_or("");
      output.statistics_within_db =
          number_at(json, "within_db").value_or(output.statistics_within_db);
      output.statistics_lags =
          static_cast<int>(std::min<std::uint64_t>(count_at(json, "lags").value_or(0), 1'000'000));
      statistics.group("arrays", [&](Io& arrays) {
        for (const auto& array : arrays.json().items()) manifest.statistics.push_back(array.key());
      });
    });
  } else if (output.statistics) {
    io.said("statistics", statistics_json(info));
  }
}

template <class Io, class Info>
void scene_members(Io& io, Info& info) {
  io.maybe("multipath", info.multipath,
           [](Io& g, auto& multipath) { multipath_members(g, multipath); });
  io.sometimes(info.bounces > 0, "bounces", info.bounces);
  io.list_if_any("paths", info.paths, [](Io& g, auto& path) { path_members(g, path); });
}

template <class Io, class Manifest>
void head_members(Io& io, Manifest& manifest) {
  auto& info = manifest.info;
  auto& output = info.output;
  number_members(io, info);
  if constexpr (!Io::kReads) {
    if (!info.recording && is_sonar(info)) io.said("model", model_json(info));
  }
  io.flag_or_null("png", output.png, [&](Io& png) { png_members(png, info); });
  io.flag_or_null("layers", output.layers, [&](Io& layers) { layer_members(layers, info); });
  io.optional("cartesian", info.cartesian, [](Io& g, auto& grid) { cartesian_members(g, grid); });
  io.optional("sdf", info.sdf, [](Io& g, auto& sdf) { sdf_members(g, sdf); });
  if constexpr (Io::kReads) {
    read_draws(io, info);
  } else {
    io.said("draws", draws_json(info.draws));
  }
  io.maybe("placement", info.placement,
           [](Io& g, auto& placement) { placement_members(g, placement); });
  instance_members(io, info);
  listing_members(io, manifest);
  scene_members(io, info);
  statistics_member(io, manifest);
  io.flag("motion", output.motion, [&](Io& motion) { motion("pings", output.motion_pings); });
  io.flag("elevation", output.elevation,
          [&](Io& elevation) { elevation_members(elevation, output); });
  io.flag("covisibility", output.covisibility, [](Io& directions) {
    directions.said("columns", kCovisibilityColumns);
    directions.said("rows", kCovisibilityRows);
  });
  io.flag("world", output.world, [](Io& world) { world_members(world); });
  io.maybe("height_map", info.height_map, [](Io& g, auto& map) { height_map_members(g, map); });
  io.maybe("navigation", info.navigation,
           [](Io& g, auto& navigation) { navigation_members(g, navigation); });
  io.maybe("camera", info.camera, [&](Io& g, auto& camera) { camera_members(g, camera, output); });
}

}  // namespace

Json sequence_head(const SequenceInfo& info, const std::vector<std::string>& each_ping,
                   std::uint64_t bytes) {
  Json json = {{"ensonify_sequence", 1}};
  MemberWriter io(json);
  const WrittenHead head{info, each_ping, bytes};
  head_members(io, head);
  return json;
}

Json sequence_schema() {
  // What a recording, a simulation without outputs, one with all of them, one of an earlier version
  // and one of a camera have in common is always there.
  Json variants = Json::array();
  for (const int parts : {0, 1, 2, 3, 4}) {
    SequenceManifest manifest;
    SequenceInfo& info = manifest.info;
    if (parts == 0) info.recording.emplace();
    if (parts == 4) info.instrument = InstrumentKind::camera;
    if (parts == 2) info.scene_sha256 = info.scenario_sha256 = "of statistics";
    if (parts == 2 || parts == 3) {
      info.sonar.transmit = TransmitGroups{.count = 2, .order = {0, 1}};
      info.motion_within_ping = info.output.layers = info.output.channels = info.output.front =
          info.output.timeseries_exr = info.output.statistics = true;
    }
    std::vector<FileEntry> files;
    variants.push_back(MemberSchema::object_of([&](MemberSchema& io) {
      io.said("ensonify_sequence", 1);
      head_members(io, manifest);
      files_member(io, files);
    }));
  }
  return {{"anyOf", std::move(variants)}};
}

std::optional<SequenceManifest> read_sequence_head(const Json& head) {
  if (!count_at(head, "ensonify_sequence")) return std::nullopt;
  SequenceManifest manifest;
  SequenceInfo& info = manifest.info;
  info.output = {.timeseries = false, .polar = false, .cartesian = false, .png = false};
  MemberReader io(head, manifest.fault);
  head_members(io, manifest);
  info.output.cartesian = info.cartesian.has_value();
  if (info.recording) {
    info.output.labels = false;
    info.sonar.bandwidth_hz = 1 / info.record.sample_interval_s;
  }
  return manifest;
}

std::optional<SequenceManifest> read_sequence_manifest(const std::filesystem::path& dir,
                                                       std::uint32_t sequence) {
  const auto file = dir / layout::in_sequence(sequence, layout::kSequenceJson);
  const auto head = parse_manifest_file(file, [](const FileEntry&) {});
  return head ? read_sequence_head(*head) : std::nullopt;
}

std::string files_opening(const Json& head) {
  std::string text = json_text(head);
  text.resize(text.rfind('\n', text.size() - 2));  // without the last brace
  return text + ",\n  \"files\": [";
}

std::string file_line(const FileEntry& entry, bool first) {
  return (first ? "\n    " : ",\n    ") + json_line(json_of(entry));
}

std::string files_closing() { return "\n  ]\n}\n"; }

bool sequence_is_whole(const std::filesystem::path& dir, std::uint32_t sequence) {
  const std::string folder = layout::sequence_folder(sequence) + "/";
  if (!listed_file_size(dir, folder + layout::kSequenceJson)) return false;
  bool whole = true;
  const auto head =
      parse_manifest_file(dir / (folder + layout::kSequenceJson), [&](const FileEntry& entry) {
        whole = whole && listed_file_size(dir, folder + entry.path) == entry.bytes;
      });
  return head && whole && count_at(*head, "ensonify_sequence") &&
         count_at(*head, "sequence") == sequence;
}

}  // namespace ensonify
