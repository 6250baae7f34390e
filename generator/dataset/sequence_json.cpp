#include "dataset/sequence_json.h"

#include "dataset/layout.h"
#include "dataset/model_json.h"
#include "dataset/packed.h"
#include "dataset/statistics.h"

namespace ensonify {
namespace {

Json record_json(const SequenceInfo& info) {
  return {{"samples", info.record.samples},
          {"transform", info.record.transform},
          {"pulse_extent_s", info.pulse_extent_s},
          {"sample_interval_s", info.record.sample_interval_s},
          {"range_step_m", sample_range_m(info.sonar, info.water, 1)}};
}

Json noise_json(const SequenceInfo& info) {
  if (!(info.noise_power_pa2 > 0)) return nullptr;
  const auto or_null = [](const std::optional<double>& v) { return v ? Json(*v) : Json(nullptr); };
  return {{"spectrum_level_db", or_null(info.noise_spectrum_level_db)},
          {"snr_db", or_null(info.noise_snr_db)},
          {"power_pa2", info.noise_power_pa2}};
}

Json cartesian_json(const CartesianGrid& grid) {
  return {{"height_px", grid.height_px},
          {"width_px", grid.width_px},
          {"metres_per_pixel", grid.m_per_px},
          {"x_top_m", grid.x_top_m},
          {"y_left_m", grid.y_left_m},
          {"pixel_centre",
           "x = x_top_m - (row + 0.5) metres_per_pixel, y = y_left_m - (column + 0.5) "
           "metres_per_pixel; x along the boresight, y to port"}};
}

Json sdf_json(const SdfGrid& sdf) {
  return {{"file", layout::kSdf},
          {"grid", "sdf"},
          {"voxel_m", sdf.voxel_m},
          {"band_voxels", sdf.band_voxels},
          {"frame", "world, at the first ping; voxel i has its middle at i voxel_m; metres"},
          {"sign", "negative in what is solid; beyond the band +- band_voxels voxel_m"}};
}

Json axes_json(const OutputSelection& output) {
  Json axes = {{"timeseries", "complex64 [beams, samples], Pa (rms), complex baseband"},
               {"polar", "rows: samples, nearest first; columns: beams, 0 first"},
               {"cartesian", "the fan from above: boresight up, port left; nearest neighbour"},
               {"first_return_m", "float32 [pings, beams], NaN: none"},
               {"level", "20 log10|p| + 120, dB re 1 uPa; -99 where there is no energy"},
               {"frames",
                "world: x east, y north, z up; sonar: x along the boresight, y to port, z up; "
                "quaternions w, x, y, z turn sonar into world"}};
  if (output.layers) {
    axes["layers"] = "complex64 [beams, samples], Pa (rms); their sum is the time series";
  }
  if (output.channels) {
    axes["channels"] =
        "complex64 [elements, samples], Pa (rms): p_n(t) of model.series, noise included, before "
        "any converter; elements by rising y";
  }
  if (output.timeseries_exr) {
    axes["timeseries_exr"] = "rows: samples, columns: beams; float channels p.re, p.im, Pa (rms)";
  }
  return axes;
}

// All that makes the picture's grey of the level Y in the EXR picture.
Json png_json(const SequenceInfo& info) {
  const GreySettings& png = info.png;
  const bool db = png.scale == GreyScale::db;
  Json json = {{"scale", db ? "db" : "amplitude"}, {"db", info.png_db_limits}};
  if (png == GreySettings{}) return json;
  json["gain_db"] = png.gain_db;
  json["tvg"] = {{"spreading", png.spreading},
                 {"absorption_db_m", png.absorption ? info.water.absorption_db_m : 0.0}};
  json["formula"] =
      std::string(
          "shown = Y + gain_db + tvg.spreading log10(r) + 2 tvg.absorption_db_m r, r the "
          "sample's range in metres, of sample 0 that of sample 1; grey = ") +
      (db ? "255 (shown - db[0]) / (db[1] - db[0])" : "255 10^((shown - db[1]) / 20)") +
      ", rounded, 0 to 255; 0 where Y = -99; Cartesian pictures show the nearest polar pixel";
  return json;
}

// Null without layers; else what each one holds.
Json layers_json(const SequenceInfo& info) {
  if (!info.output.layers) return nullptr;
  Json json = Json::object();
  for (const Layer layer : info.layers) {
    Json& about = json[layer_name(layer)];
    about = Json::object();
    if (layer == Layer::target) about["instances"] = info.target_instances;
  }
  return json;
}

Json flat_json(const std::optional<FlatSurface>& flat) {
  if (!flat) return nullptr;
  return {{"z_m", flat->z_m},
          {"reflection", flat->reflection},
          {"roughness_rms_m", flat->roughness_rms_m}};
}

// What bounced echoes came over; nothing without them.
void add_multipath(const SequenceInfo& info, Json& json) {
  if (!info.multipath) return;
  json["multipath"] = {{"surface", flat_json(info.multipath->surface)},
                       {"bottom", flat_json(info.multipath->bottom)},
                       {"objects", info.multipath->objects},
                       {"bounces", info.multipath->bounces}};
  json["paths"] = Json::array();
  for (const SoundPath& path : info.paths) {
    json["paths"].push_back({{"id", path.id}, {"out", path.out}, {"back", path.back}});
  }
}

// Shapes of the arrays that hold all pings; null where each ping has files.
Json arrays_json(const SequenceInfo& info) {
  if (!info.output.packed) return nullptr;
  Json json = Json::object();
  for (const PackedArray& array : packed_arrays(info)) {
    NpyShape shape = {info.last_ping - info.first_ping};
    shape.insert(shape.end(), array.shape.begin(), array.shape.end());
    json[array.file] = {{"dtype", array.descr.substr(1, array.descr.size() - 2)}, {"shape", shape}};
  }
  return json;
}

// Numbers as numbers, everything else as it stands in YAML.
Json draws_json(const std::vector<DrawnValue>& draws) {
  Json json = Json::object();
  for (const DrawnValue& draw : draws) {
    const auto value = parse_json(draw.value);
    json[draw.path] = value && value->is_number() ? *value : Json(draw.value);
  }
  return json;
}

}  // namespace

Json sequence_head(const SequenceInfo& info, const std::vector<std::string>& each_ping,
                   std::uint64_t bytes) {
  Json instances = Json::array();
  for (const Instance& instance : info.instances) instances.push_back(instance_json(instance));
  Json json = {{"ensonify_sequence", 1},
               {"sequence", info.sequence},
               {"seed", info.seed},
               {"split", info.split},
               {"pings", Json::array({info.first_ping, info.last_ping})},
               {"sonar", sonar_json(info)},
               {"water", water_json(info.water)},
               {"record", record_json(info)},
               {"scattering", {{"speckle", name_of(info.speckle)}}},
               {"noise", noise_json(info)},
               {"synthesis", {{"tolerance", info.synthesis_tolerance}}},
               {"model", model_json(info)},
               {"png", info.output.png ? png_json(info) : Json(nullptr)},
               {"layers", layers_json(info)},
               {"cartesian", info.cartesian ? cartesian_json(*info.cartesian) : Json(nullptr)},
               {"sdf", info.sdf ? sdf_json(*info.sdf) : Json(nullptr)},
               {"draws", draws_json(info.draws)},
               {"classes", info.classes},
               {"instances", std::move(instances)},
               {"axes", axes_json(info.output)},
               {"pack", info.output.packed ? "sequence" : "ping"},
               {"arrays", arrays_json(info)},
               {"each_ping", each_ping},
               {"bytes", bytes}};
  add_multipath(info, json);
  if (info.output.statistics) json["statistics"] = statistics_json(info);
  return json;
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
