#include "catch.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::faults_of;
using testing::parse;
using testing::tells;

// Keys beside a preset whose band is 29.9 kHz and whose range is 60 m; they begin in column 35.
std::string sonar_text(const std::string& keys) {
  return "ensonify: 1\nname: t\nsonar: {preset: blueview_p900_90, " + keys + "}\n";
}

SonarSpec sonar_with(const std::string& keys) {
  INFO(keys);
  const auto scenario = value_of(parse(sonar_text(keys)));
  return scenario.sonar;
}

void check_single_sonar_faults(const std::vector<testing::FaultCase>& cases) {
  testing::check_single_faults(cases, sonar_text);
}

// Protects the pulses: a word, or a map of it with its options.
TEST_CASE("a pulse is a word or a map of one") {
  CHECK(sonar_with("pulse: flat").pulse.shape == PulseShape::flat);
  CHECK(sonar_with("pulse: {gaussian: {}}").pulse.shape == PulseShape::gaussian);
  const PulseSpec lfm = sonar_with("pulse: {lfm: {duration_s: 1e-3}}").pulse;
  CHECK(lfm.shape == PulseShape::lfm);
  CHECK(lfm.duration_s == 1e-3);
  CHECK(lfm.taper == 0.1);
  CHECK(sonar_with("pulse: {lfm: {duration_s: 1, taper: 0.5}}").pulse.taper == 0.5);
  const PulseSpec cw = sonar_with("pulse: {cw: {duration_s: 1e-4}}").pulse;
  CHECK(cw.shape == PulseShape::cw);
  CHECK(cw.duration_s == 1e-4);
  for (const auto& [word, window] :
       {std::pair{"none", Window::none}, std::pair{"hann", Window::hann},
        std::pair{"hamming", Window::hamming}, std::pair{"blackman", Window::blackman}}) {
    CHECK(sonar_with(std::string("window: ") + word).window == window);
  }
}

TEST_CASE("a wrong pulse is told with its place") {
  check_single_sonar_faults({
      {"pulse: chirp", "3:42: sonar.pulse:", "one of gaussian, flat, lfm, cw, table"},
      {"pulse: lmf", "3:42: sonar.pulse:", "did you mean lfm?"},
      {"pulse: 7", "3:42: sonar.pulse:", "one of gaussian"},
      {"pulse: [lfm]", "3:42: sonar.pulse:", "found a list"},
      {"pulse: ", "3:35: sonar.pulse:", "found nothing"},
      {"pulse: {}", "3:42: sonar.pulse:", "missing; expected one of gaussian"},
      {"pulse: {lmf: {duration_s: 1}}", "3:43: sonar.pulse.lmf:", "did you mean lfm?"},
      {"pulse: {flat: {}, cw: {duration_s: 1e-3}}", "3:53: sonar.pulse:", "exclude each other"},
      {"pulse: {flat: {taper: 0.1}}", "3:50: sonar.pulse.flat.taper:", "this map has no keys"},
      {"pulse: {flat: 1}", "3:49: sonar.pulse.flat:", "an empty map"},
      {"pulse: lfm", "3:42: sonar.pulse.lfm.duration_s:", "missing; expected a number > 0"},
      {"pulse: {cw: {}}", "3:47: sonar.pulse.cw.duration_s:", "missing"},
      {"pulse: {lfm: }", "3:43: sonar.pulse.lfm:", "found nothing"},
      {"pulse: {lfm: {duration_s: 0}}", "3:61: sonar.pulse.lfm.duration_s:", "a number > 0"},
      {"pulse: {lfm: {duration_s: -1e-3}}", "3:61: sonar.pulse.lfm.duration_s:", "a number > 0"},
      {"pulse: {lfm: {duration_s: 1e-3, taper: 0}}", "3:74: sonar.pulse.lfm.taper:", "at most 0.5"},
      {"pulse: {lfm: {duration_s: 1e-3, taper: 0.51}}",
       "3:74: sonar.pulse.lfm.taper:", "at most 0.5"},
      {"pulse: {cw: {duration_s: 1e-3, taper: 0.1}}",
       "3:66: sonar.pulse.cw.taper:", "expected duration_s"},
      {"pulse: table", "3:42: sonar.pulse.table.file:", "missing"},
      {"pulse: {table: {file: nowhere.csv}}", "3:57: sonar.pulse.table.file:", "does not exist"},
      {"pulse: {table: {file: pulse.txt}}", "3:57: sonar.pulse.table.file:", "another extension"},
      {"window: boxcar", "3:43: sonar.window:", "one of none, hann, hamming, blackman"},
  });
}

// Protects the meaning of a chirp and of a burst: the band must hold them, the record too.
TEST_CASE("a pulse fits the band and the record") {
  // 1/b is 33.44 us, the record 80 ms.
  CHECK(sonar_with("pulse: {lfm: {duration_s: 34e-6}}").pulse.duration_s == 34e-6);
  CHECK(sonar_with("pulse: {cw: {duration_s: 34e-6}}").pulse.duration_s == 34e-6);
  CHECK(sonar_with("pulse: {cw: {duration_s: 0.08}}").pulse.duration_s == 0.08);
  CHECK(sonar_with("bandwidth_hz: 1e4, pulse: {cw: {duration_s: 1e-4}}").pulse.duration_s == 1e-4);
  check_single_sonar_faults({
      {"pulse: {lfm: {duration_s: 33e-6}}", "3:61: sonar.pulse.lfm.duration_s:", "at least 1"},
      {"pulse: {cw: {duration_s: 33e-6}}", "3:60: sonar.pulse.cw.duration_s:", "wider than the"},
      {"pulse: {cw: {duration_s: 81e-3}}", "3:60: sonar.pulse.cw.duration_s:", "record of 0.08 s"},
      {"range_max_m: 1, pulse: {cw: {duration_s: 2e-3}}",
       "3:76: sonar.pulse.cw.duration_s:", "longer than the record"},
  });
  // A chirp is compressed: its length does not show in the record.
  CHECK(sonar_with("pulse: {lfm: {duration_s: 81e-3}}").pulse.duration_s == 81e-3);
}

TEST_CASE("a table of a pulse is an input file beside the scenario") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("my pulse.csv", "frequency_hz,amplitude,phase_deg\n");
  const auto scenario = value_of(
      parse_scenario(sonar_text("pulse: {table: {file: my pulse.csv}}"), "t.yaml", folder.path()));
  CHECK(scenario.sonar.pulse.shape == PulseShape::table);
  CHECK(scenario.sonar.pulse.file == file);
  CHECK(input_files(scenario) == std::vector{file});
  CHECK(contains(emit(scenario), "pulse: {table: {file: \"" + file.string() + "\"}}\n"));
}

TEST_CASE("a shading is a word or a map of one") {
  CHECK(sonar_with("beams: {shading: uniform}").shading.kind == Shading::uniform);
  CHECK(sonar_with("beams: {shading: hann}").shading.kind == Shading::hann);
  const BeamShading word = sonar_with("beams: {shading: taylor}").shading;
  CHECK(word.kind == Shading::taylor);
  CHECK(word.side_lobe_db == -35);
  CHECK(word.nbar == 5);
  const BeamShading map =
      sonar_with("beams: {shading: {taylor: {side_lobe_db: -25, nbar: 50}}}").shading;
  CHECK(map.side_lobe_db == -25);
  CHECK(map.nbar == 50);
  const BeamShading chebyshev =
      sonar_with("beams: {shading: {chebyshev: {side_lobe_db: -80}}}").shading;
  CHECK(chebyshev.kind == Shading::chebyshev);
  CHECK(chebyshev.side_lobe_db == -80);
  CHECK(sonar_with("beams: {shading: chebyshev}").shading.side_lobe_db == -35);
  CHECK(sonar_with("beams: {transmit_width_deg: 180}").transmit_width_deg == 180);
}

// Protects the pattern in elevation from that in azimuth, and the defaults: no preset, no shading.
TEST_CASE("the pattern in elevation has a shading of its own") {
  const SonarSpec both = sonar_with(
      "beams: {shading: uniform}, elevation: {shading: {taylor: {side_lobe_db: -25, nbar: 7}}}");
  CHECK(both.shading.kind == Shading::uniform);
  CHECK(both.elevation_shading.kind == Shading::taylor);
  CHECK(both.elevation_shading.side_lobe_db == -25);
  CHECK(both.elevation_shading.nbar == 7);
  CHECK(sonar_with("elevation: {shading: chebyshev}").elevation_shading.side_lobe_db == -35);
  const auto bare = value_of(parse(
      "ensonify: 1\nsonar: {frequency_hz: 9e5, bandwidth_hz: 3e4, source_level_db: 200, "
      "range_max_m: "
      "20, beams: {count: 90, fov_deg: 45, receive_width_deg: 2}, elevation: {width_deg: 10}, "
      "rays: "
      "{elevation: 5}}\n"));
  CHECK(bare.sonar.elevation_shading.kind == Shading::uniform);
  CHECK(bare.sonar.elevation_fan_deg == 10);
  CHECK(!bare.sonar.rays_per_cell);
  check_single_sonar_faults({
      {"elevation: {shading: han}", "3:56: sonar.elevation.shading:", "did you mean hann?"},
      {"elevation: {shading: {taylor: {nbar: 4}}}",
       "3:72: sonar.elevation.shading.taylor.nbar:", "expected 5 or more"},
  });
}

// Protects Taylor's near side lobes: his sigma must fall with nbar. By hand, A = arcosh(10^(-L/20))
// / pi: L = -50 gives A^2 = 4.2147, 2 A^2 + 1/2 = 8.93; L = -80 gives 9.9375 and 20.37, where
// sigma(20) = 1.012496 is already larger than sigma(21) = 1.012489.
TEST_CASE("taylor's nbar is large enough for its side lobes") {
  CHECK(sonar_with("beams: {shading: {taylor: {side_lobe_db: -50}}}").shading.nbar == 9);
  CHECK(sonar_with("beams: {shading: {taylor: {side_lobe_db: -80}}}").shading.nbar == 20);
  CHECK(sonar_with("beams: {shading: {taylor: {side_lobe_db: -20}}}").shading.nbar == 5);
  CHECK(sonar_with("beams: {shading: {taylor: {side_lobe_db: -20, nbar: 2}}}").shading.nbar == 2);
  check_single_sonar_faults({
      {"beams: {shading: {taylor: {side_lobe_db: -50, nbar: 8}}}",
       "3:87: sonar.beams.shading.taylor.nbar:", "expected 9 or more"},
      {"beams: {shading: {taylor: {nbar: 4}}}",
       "3:68: sonar.beams.shading.taylor.nbar:", "expected 5 or more"},
      {"beams: {shading: {taylor: {nbar: 51}}}",
       "3:68: sonar.beams.shading.taylor.nbar:", "an integer from 2 to 50"},
      {"beams: {shading: {taylor: {nbar: 1}}}",
       "3:68: sonar.beams.shading.taylor.nbar:", "an integer from 2 to 50"},
  });
}

TEST_CASE("wrong beams and converters are told with their place") {
  check_single_sonar_faults({
      {"beams: {shading: tailor}", "3:52: sonar.beams.shading:", "did you mean taylor?"},
      {"beams: {shading: {hann: {nbar: 5}}}",
       "3:60: sonar.beams.shading.hann.nbar:", "this map has no keys"},
      {"beams: {shading: {chebyshev: {nbar: 5}}}",
       "3:65: sonar.beams.shading.chebyshev.nbar:", "expected side_lobe_db"},
      {"beams: {shading: {chebyshev: {side_lobe_db: -13}}}",
       "3:79: sonar.beams.shading.chebyshev.side_lobe_db:", "from -80 to -14"},
      {"beams: {shading: {taylor: {side_lobe_db: 35}}}",
       "3:76: sonar.beams.shading.taylor.side_lobe_db:", "from -80 to -14"},
      {"beams: {shading: {taylor: {side_lobe_db: -81}}}",
       "3:76: sonar.beams.shading.taylor.side_lobe_db:", "from -80 to -14"},
      {"beams: {transmit_width_deg: 0}", "3:63: sonar.beams.transmit_width_deg:", "a number > 0"},
      {"beams: {transmit_width_deg: 181}", "3:63: sonar.beams.transmit_width_deg:", "at most 180"},
      {"receiver: {modes: array}", "3:46: sonar.receiver.modes:", "did you mean mode?"},
      {"receiver: {adc: {bits: 12}}", "3:51: sonar.receiver.adc.full_scale_db:", "missing"},
      {"receiver: {adc: {full_scale_db: 1}}", "3:51: sonar.receiver.adc.bits:", "missing"},
      {"receiver: {adc: {bits: 0, full_scale_db: 170}}",
       "3:58: sonar.receiver.adc.bits:", "from 1 to 24"},
      {"receiver: {adc: {bits: 25, full_scale_db: 170}}",
       "3:58: sonar.receiver.adc.bits:", "from 1 to 24"},
      {"receiver: {adc: {bits: 12, full_scale_db: 1e3}}",
       "3:77: sonar.receiver.adc.full_scale_db:", "from -300 to 400"},
      {"receiver: 12", "3:45: sonar.receiver:", "expected a map with mode, elements"},
  });
  CHECK_FALSE(sonar_with("receiver: {}").adc);
}

// Protects `--set` over the plain word of a file or a preset, and from one kind to another.
TEST_CASE("an override changes the kind of a pulse or a shading") {
  const struct {
    std::string keys;
    std::vector<Override> overrides;
    PulseShape shape;
    double duration_s;
  } cases[] = {
      {"range_min_m: 1", {{"sonar.pulse.lfm.duration_s", "1e-3"}}, PulseShape::lfm, 1e-3},
      {"pulse: flat", {{"sonar.pulse.lfm.duration_s", "1e-3"}}, PulseShape::lfm, 1e-3},
      {"pulse: {lfm: {duration_s: 1}}",
       {{"sonar.pulse.cw.duration_s", "0.01"}},
       PulseShape::cw,
       0.01},
      {"pulse: {lfm: {duration_s: 1}}", {{"sonar.pulse.lfm.taper", "0.3"}}, PulseShape::lfm, 1},
      {"pulse: {lfm: {duration_s: 1}}", {{"sonar.pulse", "gaussian"}}, PulseShape::gaussian, 0},
      {"pulse: {lfm: {duration_s: 1}}",
       {{"sonar.pulse", "cw"}, {"sonar.pulse.cw.duration_s", "0.02"}},
       PulseShape::cw,
       0.02},
  };
  for (const auto& c : cases) {
    INFO(c.keys);
    const auto scenario = value_of(parse(sonar_text(c.keys), c.overrides));
    CHECK(scenario.sonar.pulse.shape == c.shape);
    CHECK(scenario.sonar.pulse.duration_s == c.duration_s);
  }
  const auto shaded = value_of(parse(sonar_text("beams: {shading: taylor}"),
                                     {{"sonar.beams.shading.taylor.side_lobe_db", "-50"}}));
  CHECK(shaded.sonar.shading.side_lobe_db == -50);
  CHECK(shaded.sonar.shading.nbar == 9);
  const auto other = value_of(parse(sonar_text("beams: {shading: {taylor: {nbar: 7}}}"),
                                    {{"sonar.beams.shading.chebyshev.side_lobe_db", "-30"}}));
  CHECK(other.sonar.shading.kind == Shading::chebyshev);
}

TEST_CASE("an override of a pulse that is wrong names the option or the file") {
  const auto unknown = faults_of(sonar_text("pulse: flat"), {{"sonar.pulse.chirp", "1"}});
  CHECK(unknown.size() == 1);
  CHECK(tells(unknown, "--set sonar.pulse.chirp: sonar.pulse.chirp:", "unknown key"));
  const auto taper = faults_of(sonar_text("pulse: flat"), {{"sonar.pulse.lfm.taper", "0.2"}});
  CHECK(taper.size() == 1);
  CHECK(tells(taper, "--set sonar.pulse.lfm.taper: sonar.pulse.lfm.duration_s:", "missing"));
  const auto garbage = faults_of(sonar_text("pulse: flatt"), {{"sonar.pulse.lfm.duration_s", "1e-3"}});
  CHECK(tells(garbage, "t.yaml:3:42: sonar.pulse.flatt:", "unknown key"));
}

}  // namespace
}  // namespace ensonify
