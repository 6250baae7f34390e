#include "scenario/key_facts.h"

#include <algorithm>

#include "catch.h"

namespace ensonify {
namespace {

bool holds(const std::vector<std::string_view>& keys, std::string_view key) {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

Node word(const std::string& text) {
  Node node;
  node.kind = NodeKind::scalar;
  node.text = text;
  return node;
}

// Protects --set and presets: what is put in takes the place of what cannot stand beside it.
TEST_CASE("keys that cannot stand together exclude each other, either way") {
  const std::pair<std::string_view, std::string_view> pairs[] = {
      {"spacing_deg", "fov_deg"},
      {"azimuths_deg", "fov_deg"},
      {"azimuths_deg", "spacing_deg"},
      {"receive_widths_deg", "receive_width_deg"},
      {"rotation_deg", "quaternion_wxyz"},
      {"fixed_db_m", "model"},
      {"fixed_db_m", "ph"},
      {"poses", "file"},
      {"poses", "orbit"},
      {"depth_m", "file"},
      {"sound_speed_m_s", "file"},
      {"box", "level_set"},
      {"size_m", "file"},
      {"roughness", "file"},
      {"size_m", "height_scale"},
      {"vdb", "school"},
      {"lfm", "table"},
      {"hann", "chebyshev"},
      {"lambert", "table"},
      {"reflectivity", "backscatter_strength_db"},
      {"plume", "extinction_db_m"},
      {"snr_db", "spectrum_level_db"},
      {"pose", "place"},
  };
  for (const auto& [one, other] : pairs) {
    INFO(one << " " << other);
    CHECK(holds(excluded_by(one), other));
    CHECK(holds(excluded_by(other), one));
  }
  // An instrument of a rig is only one of the last three, and a scenario has all.
  for (const char* key : {"name", "cell_m", "position_m", "surface_z_m", "count", "wave_motion",
                          "sonar", "camera", "navigation"}) {
    INFO(key);
    CHECK(excluded_by(key).empty());
  }
}

TEST_CASE("a value excludes keys beside it") {
  using Keys = std::vector<std::string_view>;
  CHECK(excluded_by_value("law", word("table")) == Keys{"backscatter_strength_db", "reflectivity"});
  CHECK(excluded_by_value("law", word("lambert")).empty());
  CHECK(excluded_by_value("model", word("rician")) ==
        Keys{"edges", "reflection", "roughness_correlation_m", "roughness_rms_m"});
  CHECK(excluded_by_value("model", word("kirchhoff")) == Keys{"k"});
  CHECK(excluded_by_value("mode", word("beams")).size() == 9);
  CHECK(excluded_by_value("mode", word("array")).empty());
}

// Protects draws: what reads whole numbers is drawn as whole numbers.
TEST_CASE("key paths tell whole numbers, files, kinds and names") {
  for (const char* path :
       {"sonar.beams.count", "sonar.rays.azimuth", "objects.2.count", "volumes.shoal.school.fish",
        "sonar.receiver.dead.4", "sonar.beams.shading.taylor.nbar", "trajectory.pings"}) {
    INFO(path);
    CHECK(reads_whole_numbers(path));
  }
  for (const char* path : {"sonar.beams.receive_width_deg", "objects.2", "count", "seed", ""}) {
    INFO(path);
    CHECK_FALSE(reads_whole_numbers(path));
  }
  CHECK(names_file("file"));
  CHECK(names_file("reflectivity_map"));
  CHECK_FALSE(names_file("grid"));
  using Path = std::vector<std::string_view>;
  CHECK(holds_kind(Path{"sonar", "pulse"}));
  CHECK(holds_kind(Path{"materials", "sand", "law"}));
  CHECK_FALSE(holds_kind(Path{"materials", "sand"}));
  CHECK(holds_names(Path{"materials"}));
  CHECK(holds_names(Path{"objects", "0", "shape", "mesh", "parts"}));
  CHECK_FALSE(holds_names(Path{"objects", "0"}));
}

}  // namespace
}  // namespace ensonify
