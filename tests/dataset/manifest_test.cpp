// sequence.json: what it says, and that it is read as it was written.
#include <limits>

#include "catch.h"
#include "core/units.h"
#include "dataset/manifest_json.h"
#include "dataset/manifest_members.h"
#include "dataset/sample.h"
#include "dataset/table_rows.h"
#include "results.h"

using namespace ensonify;

namespace {

std::string words(const SequenceInfo& info, const char* key) {
  return model_json(info)[key].get<std::string>();
}

Json sonar_json(const SequenceInfo& info) { return sequence_head(info, {}, 0)["sonar"]; }

Json instance_json(const Instance& instance) {
  SequenceInfo info = sample::sequence_info(0);
  info.instances = {instance};
  return sequence_head(info, {}, 0)["instances"][0];
}

// By way of a file's text, in which numbers have no sign where they need none.
std::optional<SequenceManifest> read_again(const Json& head) {
  return read_sequence_head(*parse_json(json_text(head)));
}

// Everything that a sequence can have.
SequenceInfo full_info() {
  SequenceInfo info = sample::sequence_info(3);
  Sonar& sonar = info.sonar;
  sonar.pulse = {PulseShape::table, 0, 0.1, {{9e5, 1, 0.5}, {9.1e5, 2, -0.5}}};
  sonar.window = Window::hamming;
  sonar.shading = {Shading::taylor, -40, 6};
  sonar.transmit_width_rad = 1.5;
  sonar.adc = Adc{12, 180};
  sonar.array = ArrayReceiver{
      2, 0.1, 0.01, {Shading::chebyshev, -30, 5}, Focus::none, Steering::phase, {{1, 0.5}, 0}};
  info.element_y_m = {-0.05, 0.05};
  info.element_weight = {0.5, 0.5};
  info.water.profile = SoundProfile{1, {0, 10}, {1500, 1490}};
  info.speckle = SpeckleMode::surface;
  info.multipath = Multipath{FlatSurface{0, -1, 0.01}, {}, true, 3};
  info.paths = {{1, {"surface"}, {}}};
  info.sdf = SdfGrid{0.1, 4};
  info.output.world = true;
  info.height_map = HeightMap{0.25, 3, 5, -0.5, 2.25};
  info.navigation = NavigationInfo{{.dvl = Dvl{{5, 0.1}, SensorMount{{1, 2, 3}, {0, 0, 90}}}}, {{1, 0, 0}, {0, 1, 0, 0}}};
  info.png = {GreyScale::amplitude, 0.5, 3, 20, false, true, {50, 90}};
  info.png.resampling = Resampling::nearest;
  info.png_counts = {100, 3, 50, 7};
  info.draws = {{"objects.a", "0.5"}, {"objects.b", "[1, two]"}};
  info.output.layers = info.output.channels = info.output.packed = info.output.statistics = true;
  info.output.statistics_lags = 5;
  info.output.statistics_within_db = 12;
  info.scene_sha256 = "of the scene";
  info.scenario_sha256 = "of the scenario";
  info.layers = {Layer::noise, Layer::target};
  info.target_instances = {2};
  Material steel{.law = LommelSeeliger{}, .reflectivity = 0.5};
  steel.coherent = CoherentModel::kirchhoff;
  steel.roughness_rms_m = 1e-4;
  steel.roughness_correlation_m = 2e-3;
  steel.edges = true;
  info.instances[0].parts = {{"mast", "steel", steel}};
  info.instances[0].elastic = ElasticBody{0.2, kAluminum, 0.2, {}};
  info.instances[0].image_reflectivity = true;
  info.instances.push_back(info.instances[1]);
  info.instances.back().id = 3;
  info.instances.back().kind = InstanceKind::volume;
  info.instances.back().volume_strength_db = -60;
  info.instances.back().volume_patches = {TextureModel::lognormal, 1, 4, 2};
  info.water.density_kg_m3 = 1000;
  info.instances.push_back(info.instances.back());
  info.instances.back().id = 4;
  info.instances.back().kind = InstanceKind::point_target;
  info.instances.back().elastic = ElasticBody{0.1, kSteel, 0.002, kAir};
  return info;
}

Instance surface(const Material& material) {
  Instance instance;
  instance.scattering = material;
  return instance;
}

}  // namespace

// Protects the words of the model: they have to change with the sonar they describe.
TEST_CASE("the model describes the normalization in use") {
  auto info = sample::sequence_info(0);
  CHECK(words(info, "beam_normalization") == "N_j = 1");
  info.sonar.normalization = Normalization::mean_square;
  CHECK(words(info, "beam_normalization").starts_with("N_j = sqrt("));
  info.noise_power_pa2 = 0;
  CHECK(sequence_head(info, {}, 0)["noise"].is_null());
}

TEST_CASE("the model speaks of motion where there is any") {
  SequenceInfo info = sample::sequence_info(0);
  CHECK_FALSE(model_json(info).contains("motion"));
  info.motion_within_ping = true;
  CHECK(contains(model_json(info)["motion"].get<std::string>(), "tau_i later"));
}

TEST_CASE("the model describes pulse and window") {
  auto info = sample::sequence_info(0);
  CHECK(words(info, "pulse_spectrum").starts_with("W(d) = exp("));
  CHECK(sonar_json(info)["pulse"] == Json({{"shape", "gaussian"}}));
  info.sonar.pulse = {PulseShape::lfm, 1e-3, 0.25, {}};
  CHECK(words(info, "pulse_spectrum").starts_with("W(d) = T(d); T(d) = 1 for |d| <= (0.5 - e) b"));
  CHECK(sonar_json(info)["pulse"] ==
        Json({{"shape", "lfm"}, {"duration_s", 1e-3}, {"taper", 0.25}}));
  info.sonar.pulse = {PulseShape::cw, 1e-3, 0.1, {}};
  info.sonar.window = Window::hann;
  CHECK(contains(words(info, "pulse_spectrum"), "T(d) (1 + cos(2 pi d/b))/2;"));
  info.sonar.pulse = {PulseShape::table, 0, 0.1, {{9e5, 1, 0.5}, {9.1e5, 2, -0.5}}};
  CHECK(sonar_json(info)["pulse"]["rows"] == Json({{9e5, 1, 0.5}, {9.1e5, 2, -0.5}}));
}

TEST_CASE("the model describes the beams and the converter") {
  auto info = sample::sequence_info(0);
  info.receive_aperture_wavelengths = 70;
  CHECK(sonar_json(info)["beams"]["shading"] ==
        Json({{"kind", "uniform"}, {"aperture_wavelengths", 70.0}}));
  CHECK(sonar_json(info)["beams"]["transmit_width_rad"].is_null());
  CHECK(sonar_json(info)["adc"].is_null());
  info.sonar.shading = {Shading::taylor, -40, 6};
  info.sonar.transmit_width_rad = 1.5;
  info.sonar.adc = Adc{12, 180};
  const Json sonar = sonar_json(info);
  CHECK(sonar["beams"]["shading"]["side_lobe_db"] == -40);
  CHECK(sonar["beams"]["shading"]["nbar"] == 6);
  CHECK(sonar["beams"]["transmit_width_rad"] == 1.5);
  // Full scale 1000 Pa over 2^11 steps.
  CHECK(sonar["adc"]["step_pa"].get<double>() == Approx(1000.0 / 2048));
  CHECK(contains(words(info, "beam_pattern"), "prod_{n=1}"));
  info.sonar.shading.kind = Shading::chebyshev;
  CHECK(contains(words(info, "beam_pattern"), "cosh"));
}

// Protects who rebuilds gains from a file: the pattern in elevation is not that of the beams.
TEST_CASE("the model describes the pattern in elevation") {
  auto info = sample::sequence_info(0);
  info.sonar.elevation_line.aperture = 3;
  CHECK(sonar_json(info)["elevation"]["shading"] ==
        Json({{"kind", "uniform"}, {"aperture_wavelengths", 3.0}}));
  CHECK(words(info, "elevation_pattern").starts_with("B(elevation_rad) = sin(pi u)/(pi u); "));
  info.sonar.elevation_line.shading = {Shading::taylor, -40, 6};
  CHECK(sonar_json(info)["elevation"]["shading"]["side_lobe_db"] == -40);
  CHECK(sonar_json(info)["elevation"]["shading"]["nbar"] == 6);
  CHECK(sonar_json(info)["beams"]["shading"]["kind"] == "uniform");
  CHECK(contains(words(info, "elevation_pattern"), "prod_{n=1}"));
  CHECK_FALSE(contains(words(info, "beam_pattern"), "prod_{n=1}"));
}

// Protects readers of an array's data: every number of every element, and its own formulas; nothing
// new in a data set of beams.
TEST_CASE("the model describes an array") {
  auto info = sample::sequence_info(0);
  CHECK_FALSE(sonar_json(info).contains("receiver"));
  ArrayReceiver& array = info.sonar.array.emplace();
  array.elements = 2;
  array.spacing_m = 0.1;
  array.shading = {Shading::taylor, -30, 4};
  array.response = {{1, 0.5}, 0};
  info.element_y_m = {-0.05, 0.05};
  info.element_weight = {0.5, 0.5};
  const Json receiver = sonar_json(info)["receiver"];
  CHECK(receiver["elements"] == 2);
  CHECK(receiver["y_m"] == Json({-0.05, 0.05}));
  CHECK(receiver["response_re"] == Json({1.0, 0.0}));
  CHECK(receiver["response_im"] == Json({0.5, 0.0}));
  CHECK(receiver["shading"]["nbar"] == 4);
  CHECK(contains(words(info, "series"), "(D_nj + F_njk)) p_n(t_k + D_nj)"));
  CHECK(words(info, "beam_pattern") == "E(u) = 1");
  array.focus = Focus::none;
  array.steering = Steering::phase;
  array.element_width_m = 0.01;
  CHECK(contains(words(info, "series"), "D_nj) p_n(t_k)"));
  CHECK_FALSE(model_json(info)["symbols"].contains("F_njk"));
  CHECK(words(info, "beam_pattern").starts_with("E(u) = sin(pi v)/(pi v)"));
}

// Protects readers that work levels out again: each instance says how it throws back.
TEST_CASE("an instance tells its law") {
  Material material;
  material.reflectivity = 1e-3;
  material.law = Lambert{2};
  CHECK(instance_json(surface(material))["law"] ==
        Json({{"model", "lambert"}, {"reflectivity", 1e-3}, {"exponent", 2.0}}));
  CHECK(instance_json(surface(material))["coherent"].is_null());
  material.law = LommelSeeliger{};
  material.coherent = CoherentModel::rician;
  material.rician_k = 0.5;
  CHECK(instance_json(surface(material))["law"]["model"] == "lommel_seeliger");
  CHECK(instance_json(surface(material))["coherent"] == Json({{"model", "rician"}, {"k", 0.5}}));
  material.law = MeasuredStrength{{}, {{0, kPi / 2}, {-40, -10}}};
  material.coherent = CoherentModel::kirchhoff;
  material.reflection = -0.5;
  material.roughness_rms_m = 1e-4;
  const Json json = instance_json(surface(material));
  CHECK(json["law"]["rows"] == Json({{0.0, -40.0}, {90.0, -10.0}}));
  CHECK(json["coherent"]["reflection"] == -0.5);
  CHECK(json["coherent"]["roughness_rms_m"] == 1e-4);
  CHECK_FALSE(json["coherent"].contains("edges"));
  CHECK_FALSE(json["coherent"].contains("roughness_correlation_m"));
  material.edges = true;
  material.roughness_correlation_m = 2e-3;
  CHECK(instance_json(surface(material))["coherent"]["edges"] == true);
  CHECK(instance_json(surface(material))["coherent"]["roughness_correlation_m"] == 2e-3);
}

TEST_CASE("a volume tells its strength") {
  Instance instance;
  instance.kind = InstanceKind::volume;
  instance.volume_strength_db = -60;
  CHECK(instance_json(instance)["kind"] == "volume");
  CHECK(instance_json(instance)["strength_db"] == -60);
  CHECK_FALSE(instance_json(instance).contains("patches"));
  instance.volume_patches = {TextureModel::gamma, 2, 3, 0.5};
  CHECK(instance_json(instance)["patches"] ==
        Json({{"model", "gamma"}, {"shape", 2.0}, {"correlation_m", 0.5}}));
}

TEST_CASE("a surface says whether an image scales it") {
  Instance instance = surface({.reflectivity = 1e-3});
  CHECK_FALSE(instance_json(instance).contains("image_reflectivity"));
  instance.image_reflectivity = true;
  CHECK(instance_json(instance)["image_reflectivity"] == true);
}

// Protects whoever works the laws out again: a part's own law stands beside the object's.
TEST_CASE("parts of an instance say how they scatter") {
  Instance instance = surface({.reflectivity = 1e-3});
  CHECK_FALSE(instance_json(instance).contains("parts"));
  Material steel{.law = LommelSeeliger{}, .reflectivity = 0.5};
  steel.coherent = CoherentModel::rician;
  steel.rician_k = 2;
  instance.parts = {{"mast", "steel", steel}};
  CHECK(instance_json(instance)["parts"] ==
        Json::array({{{"name", "mast"},
                      {"material", "steel"},
                      {"law", {{"model", "lommel_seeliger"}, {"reflectivity", 0.5}}},
                      {"coherent", {{"model", "rician"}, {"k", 2.0}}}}}));
}

// Protects readers of data sets: what the program writes it reads, member for member.
TEST_CASE("sequence.json is read as it was written") {
  const SequenceInfo info = GENERATE(full_info(), sample::sequence_info(0));
  const Json head = sequence_head(info, {"points/{ping}.ply"}, 17);
  const auto manifest = value_of(read_again(head));
  CHECK(manifest.fault.empty());
  CHECK(manifest.each_ping == std::vector<std::string>{"points/{ping}.ply"});
  CHECK(manifest.bytes == 17);
  CHECK(manifest.arrays.size() == head["arrays"].size());
  CHECK(manifest.realisations == (info.output.statistics ? 3u : 0u));
  const Json again = sequence_head(manifest.info, manifest.each_ping, manifest.bytes);
  // What follows from the choice of outputs is not read back from them.
  for (const char* key : {"sonar", "water", "record", "noise", "model", "png", "layers",
                          "cartesian", "sdf", "world", "height_map", "navigation", "draws", "classes", "instances", "statistics"}) {
    INFO(key);
    CHECK(again.value(key, Json()) == head.value(key, Json()));
  }
}

// Protects readers from forged manifests: a member of a wrong kind is named, and nothing throws.
TEST_CASE("a member of a wrong kind is named") {
  const SequenceInfo info = sample::sequence_info(0);
  const auto fault = [&](const char* pointer, const Json& value) {
    Json head = sequence_head(info, {}, 0);
    head[Json::json_pointer(pointer)] = value;
    return read_again(head)->fault;
  };
  CHECK(fault("/sonar/beams/count", "many") == "sonar.beams.count");
  CHECK(fault("/sonar/beams/count", 1e10) == "sonar.beams.count");
  CHECK(fault("/sonar/beams", 3) == "sonar.beams");
  CHECK(fault("/pings", {3, 1}) == "pings");
  CHECK(fault("/instances/1/id", -1) == "instances[1].id");
  CHECK(fault("/instances/0/box/size_m", {1, 2}) == "instances[0].box.size_m");
  CHECK(fault("/each_ping", {1}) == "each_ping");
  CHECK(fault("/png", nullptr).empty());
  CHECK_FALSE(read_sequence_head(Json(3)));
}

// Protects readers that work the series out again: every number of the formula is there, in SI
// units and radians.
TEST_CASE("sequence.json has the numbers of the beam model") {
  const auto info = sample::sequence_info(0);
  const Json head = sequence_head(info, {"timeseries/{ping}.npy"}, 10);
  CHECK(head["sonar"]["frequency_hz"] == 900e3);
  CHECK(head["sonar"]["bandwidth_hz"] == 29.9e3);
  CHECK(head["sonar"]["source_pressure_pa_m"].get<double>() == Approx(1e5));
  CHECK(head["sonar"]["beams"]["count"] == sample::kBeams);
  CHECK(head["sonar"]["beams"]["first_azimuth_rad"].get<double>() == Approx(-0.75));
  CHECK(head["sonar"]["beams"]["width_rad"] == 0.02);
  CHECK(head["record"]["samples"] == sample::kSamples);
  CHECK(head["record"]["transform"] == 128);
  CHECK(head["record"]["sample_interval_s"] == 1 / 29.9e3);
  CHECK(head["noise"]["spectrum_level_db"] == 30);
  CHECK(head["noise"]["power_pa2"] == 2.99e-5);
  CHECK(head["noise"]["snr_db"].is_null());
  CHECK(head["instances"][1]["target_strength_db"] == -40);
  CHECK(head["instances"][0]["material"] == "concrete");
  CHECK(head["cartesian"]["metres_per_pixel"] == 0.03);
  CHECK(head["png"]["db"] == Json({60.0, 120.0}));
  CHECK(head["seed"] == 18446744073709551615u);
}

// Protects the piecewise writing: opening, lines and closing make one JSON document.
TEST_CASE("sequence.json written in pieces is JSON with its files") {
  const Json head = sequence_head(sample::sequence_info(0), {}, 3);
  const std::string text = files_opening(head) + file_line({"a", 1, "x"}, true) +
                           file_line({"b", 2, "y"}, false) + files_closing();
  std::vector<FileEntry> entries;
  const auto json =
      value_of(parse_manifest(text, [&](FileEntry entry) { entries.push_back(entry); }));
  REQUIRE(entries.size() == 2);
  CHECK(entries[1].path == "b");
  CHECK(entries[1].bytes == 2);
  CHECK(json["files"].empty());
  CHECK(json["instances"].size() == 2);
  CHECK(json["sonar"] == head["sonar"]);
}

// Protects JSON from numbers it has no word for.
TEST_CASE("what is not a number becomes null") {
  CHECK(number_or_null(std::numeric_limits<double>::quiet_NaN()).is_null());
  CHECK(number_or_null(std::numeric_limits<double>::infinity()).is_null());
  CHECK(json_line(number_or_null(0.1)) == "0.1");
}

// Protects readers of manifests from foreign content: nothing of the wrong kind may throw.
TEST_CASE("members of the wrong kind are none") {
  const Json json = *parse_json(R"({"text": 1, "count": -1, "number": "x", "list": []})");
  CHECK_FALSE(text_at(json, "text"));
  CHECK_FALSE(count_at(json, "count"));
  CHECK_FALSE(number_at(json, "number"));
  CHECK_FALSE(text_at(json["list"], "a"));
  CHECK_FALSE(parse_json("{"));
  CHECK_FALSE(parse_manifest("[]", [](const FileEntry&) {}));
  bool empty = false;
  CHECK(parse_manifest(R"({"files": [{"path": 3}]})",
                       [&](const FileEntry& entry) { empty = entry.path.empty(); }));
  CHECK(empty);
}

// Protects tables from lost digits and locale: shortest form that reads back to the same double.
TEST_CASE("tables hold the shortest form of a number") {
  const Pose pose{{0.1, 1e-9, 123456789.125}, {1, 0, 0, 0}};
  CHECK(poses_row(3, 0.30000000000000004, pose) ==
        "3,0.30000000000000004,0.1,1e-09,123456789.125,1,0,0,0\n");
  CHECK(index_row(2, 3, 0.5, "val") == "2,3,0.5,val,000002/000003\n");
}
