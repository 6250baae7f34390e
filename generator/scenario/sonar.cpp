// The keys of the sonar: preset, pulse, ranges, elevation and rays.
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "core/units.h"
#include "scenario/merge.h"
#include "scenario/preset_values.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

constexpr int kMaxPerCell = 1000;
constexpr NumberRange kDuration = above_up_to(0, 100);
constexpr NumberRange kTaper = above_up_to(0, 0.5);

// A larger ping would take more than 2 GiB for a single stage, or days of computing.
constexpr double kMaxPixels = 268435456.0;     // 2^28 beams x samples
constexpr double kMaxSonarRays = 134217728.0;  // 2^27 beams x rays

// Numbers in a file are rounded, so a product that should be 1 may be this much too small.
constexpr double kRounding = 1e-9;

void set_source(Node& node, int source) {
  node.place.source = source;
  for (Key& key : node.keys) key.place.source = source;
  for (Node& item : node.items) set_source(item, source);
}

// Merges the map over the preset that it names, which `keys` then holds. Returns whether the keys
// that a preset provides are required.
Need read_preset(Fields& f, std::optional<PresetKeys>& keys) {
  std::vector<std::string_view> names;
  for (const SonarPreset& preset : sonar_presets()) names.push_back(preset.name);
  std::size_t index = 0;
  const bool read = f.word(
      {"preset", "Preset",
       "Built-in sonar whose keys the other keys override; `ensonify presets NAME` prints it "
       "with its sources; left out: the other keys describe the whole sonar"},
      names, index, written_if(false, {.has_default = false}));
  FieldReader* reader = f.reader();
  if (reader == nullptr) return Need::required;
  if (!read) {
    // An unknown preset has been reported and might have set the other keys, so one error is
    // enough.
    if (f.peek("preset") != nullptr) return Need::optional;
    if (f.peek("frequency_hz") != nullptr) return Need::required;
    f.fault("preset",
            "missing, and so is frequency_hz; expected a preset (`ensonify presets` lists them) or "
            "all keys that are reported here");
    return Need::required;
  }
  Node tree = preset_tree(index, *reader->map().node);
  keys = {sonar_presets()[index].name, tree, reader->map().node};
  set_source(tree, add_source(reader->faults(), "preset " + sonar_presets()[index].name));
  reader->replace_map(merge_over(std::move(tree), *reader->map().node));
  return Need::required;
}

// Returns the value of the pulse's duration, if it has one.
std::optional<Value> duration_in(const Value& sonar) {
  const auto pulse = child(sonar, "pulse");
  if (!pulse) return std::nullopt;
  for (const char* word : {"lfm", "cw"}) {
    if (const auto options = child(*pulse, word)) return child(*options, "duration_s");
  }
  return std::nullopt;
}

// In the order of PulseShape.
constexpr KindText kPulseTexts[] = {
    {"Gaussian", "The pulse of Choi et al. 2021"},
    {"Flat spectrum", "The whole band, as short as the band allows"},
    {"Linear chirp", "A linear frequency-modulated chirp after its matched filter"},
    {"Tone burst", "A tone burst at the carrier frequency"},
    {"Measured spectrum", "A spectrum read from a table"},
};

void pulse_fields(Fields& f, PulseSpec& pulse) {
  if (!f.begin_kind({"pulse", "Pulse", "Shape of the echo of a single point"}, pulse.shape,
                    PulseShape::table, kPulseTexts)) {
    return;
  }
  const bool is_chirp = pulse.shape == PulseShape::lfm;
  if (is_chirp || pulse.shape == PulseShape::cw) {
    f.number({"duration_s", "Duration",
              is_chirp ? "Duration of the chirp; its product with bandwidth_hz is at least 1"
                       : "Duration of the burst; its product with bandwidth_hz is at least 1, and "
                         "it is no longer than the record"},
             pulse.duration_s, kDuration, kRequired);
  }
  if (is_chirp) {
    f.number(
        {"taper", "Taper", "Fraction of the band over which the spectrum falls off at each edge"},
        pulse.taper, kTaper);
  }
  if (pulse.shape == PulseShape::table) {
    f.file({"file", "Spectrum file",
            "CSV file with the columns frequency_hz, amplitude and phase_deg"},
           pulse.file, {".csv"}, kRequired);
  }
  f.end();
}

void check_band(Faults& faults, const Value& map, const SonarSpec& sonar) {
  const auto frequency = child(map, "frequency_hz");
  const auto bandwidth = child(map, "bandwidth_hz");
  if (!frequency || !bandwidth || sonar.frequency_hz == 0 || sonar.bandwidth_hz == 0) return;
  if (sonar.frequency_hz > sonar.bandwidth_hz / 2) return;
  const Value culprit = blamed(*bandwidth, *frequency);
  add_fault(faults, culprit.place, culprit.path,
            fmt::format("a band of {} Hz around {} Hz extends below zero; expected a bandwidth_hz "
                        "below twice frequency_hz",
                        sonar.bandwidth_hz, sonar.frequency_hz));
}

// Checks that a chirp or burst is long enough for the bandwidth.
void check_pulse_band(Faults& faults, const Value& sonar_value, const SonarSpec& sonar) {
  const auto duration = duration_in(sonar_value);
  const auto bandwidth = child(sonar_value, "bandwidth_hz");
  const double duration_s = sonar.pulse.duration_s;
  if (!duration || !bandwidth || duration_s == 0 || sonar.bandwidth_hz == 0) return;
  if (duration_s * sonar.bandwidth_hz >= 1 - kRounding) return;
  const Value culprit = blamed(*duration, *bandwidth);
  const std::string_view trouble = sonar.pulse.shape == PulseShape::cw
                                       ? "a burst this short is wider than the band"
                                       : "a chirp this short cannot be compressed";
  add_fault(
      faults, culprit.place, culprit.path,
      fmt::format(
          "duration_s {} times bandwidth_hz {} is {:.3g}: {}; expected a product of at least 1",
          duration_s, sonar.bandwidth_hz, duration_s * sonar.bandwidth_hz, trouble));
}

void check_ranges(Faults& faults, const Value& map, const SonarSpec& sonar) {
  const auto far = child(map, "range_max_m");
  const auto near = child(map, "range_min_m");
  if (!far || sonar.range_max_m == 0 || sonar.range_max_m > sonar.range_min_m) return;
  const Value culprit = near ? blamed(*far, *near) : *far;
  add_fault(
      faults, culprit.place, culprit.path,
      fmt::format(
          "range_min_m {} is not below range_max_m {}; expected 0 <= range_min_m < range_max_m",
          sonar.range_min_m, sonar.range_max_m));
}

void carrier_fields(Fields& f, SonarSpec& sonar, const Rule& needed) {
  f.number({"frequency_hz", "Carrier frequency", "f_c"}, sonar.frequency_hz, above_up_to(0, 1e9),
           needed);
  f.number(
      {"bandwidth_hz", "Bandwidth",
       "b, less than twice frequency_hz; the sample interval is 1/b and the range step c/(2b)"},
      sonar.bandwidth_hz, above_up_to(0, 1e9), needed);
  pulse_fields(f, sonar.pulse);
  f.choice<Window>({"window", "Spectral window",
                    "Window that the receiver applies to the spectrum over the band: it lowers the "
                    "range side lobes and widens the peak"},
                   sonar.window, words_to(Window::blackman));
  f.number({"source_level_db", "Source level", "Source level (rms)", "dB re 1 µPa·m"},
           sonar.source_level_db, kLevelDb, needed);
}

void range_fields(Fields& f, SonarSpec& sonar, const Rule& needed) {
  f.number({"range_min_m", "Minimum range",
            "Echoes closer than this are dropped; their samples stay in the time series"},
           sonar.range_min_m, from_to(0, kMaxLengthM));
  f.number({"range_max_m", "Maximum range",
            "Range of the farthest echo and length of the record; above range_min_m"},
           sonar.range_max_m, above_up_to(0, kMaxLengthM), needed);
}

void elevation_fields(Fields& f, SonarSpec& sonar, const Rule& needed) {
  if (!f.begin({"elevation", "Elevation", "Beam pattern in elevation"}, needed)) return;
  f.number({"width_deg", "Beam width", "-3 dB width of the two-way pattern in elevation"},
           sonar.elevation_width_deg, kAngle, needed);
  shading_fields(f,
                 {"shading", "Shading",
                  "Shape of the two-way pattern, as of an aperture with these weights; the -3 dB "
                  "width is kept"},
                 sonar.elevation_shading);
  if (!f.writing()) sonar.elevation_fan_deg = sonar.elevation_width_deg;
  f.number({"fan_deg", "Fan of rays",
            "Angle in elevation that the rays span, half of it on either side of the boresight; "
            "left out: the value of width_deg; with a preset, its own, or up to the first zeros of "
            "the pattern if width_deg or shading differ from it"},
           sonar.elevation_fan_deg, kAngle, {.has_default = false});
  f.end();
}

void ray_fields(Fields& f, SonarSpec& sonar, const Rule& needed) {
  if (!f.begin({"rays", "Rays", "How densely the fan is sampled"}, needed)) return;
  f.integer({"elevation", "Rays in elevation",
             "Rays over the height of the fan in each column; with a preset whose narrower fan "
             "follows width_deg, as dense as there unless given"},
            sonar.rays_elevation, 1, kMaxRays, needed);
  f.integer({"azimuth", "Columns of rays", "Columns of rays in each beam cell"}, sonar.rays_azimuth,
            1, kMaxRays);
  f.renamed("per_cell", "min_per_cell");
  f.integer({"min_per_cell", "Minimum per resolution cell",
             "Adaptive refinement: cells of the fan are split in elevation until a resolution cell "
             "of every surface holds at least this many scatterers; 0 splits no cell; left out: "
             "as few as keep the expected level within 0.02 dB rms on even surfaces, more on "
             "others and 30 at edges"},
            sonar.rays_per_cell, 0, kMaxPerCell);
  f.end();
}

}  // namespace

Value blamed(const Value& value, const Value& other) {
  return other.place.source < value.place.source ? other : value;
}

void fields(Fields& f, SonarSpec& sonar) {
  std::optional<PresetKeys> preset;
  const Need need = read_preset(f, preset);
  const Rule needed{.need = need, .unless = "preset"};
  const ReadWatch watch(f);
  carrier_fields(f, sonar, needed);
  range_fields(f, sonar, needed);
  if (f.begin({"beams", "Beams", "Receive fan in azimuth"}, needed)) {
    beam_fields(f, sonar, need);
    f.end();
  }
  elevation_fields(f, sonar, needed);
  ray_fields(f, sonar, needed);
  // A scenario without this key has a receiver with ideal beam cells and no ADC.
  if (f.begin({"receiver", "Receiver",
               "How beams are formed, from ideal beam cells or from an array of elements, and the "
               "ADC; left out: ideal beam cells without an ADC"},
              written_if(sonar.array || sonar.adc, {.has_default = false}))) {
    receiver_fields(f, sonar);
    f.end();
  }
  transmit_fields(f, sonar, need);
  f.map({"electronics", "Electronics",
         "What the receiver's electronics do to the beams before the ADC; left out: nothing"},
        sonar.electronics);
  f.map({"detector", "Detector",
         "How complex samples become the levels of images and counts, after the ADC; left out: the "
         "level of a sample is that of its power"},
        sonar.detector);
  f.map({"recorder", "Recorder",
         "How the instrument stores its images, as counts; left out: no counts are written"},
        sonar.recorder);
  f.map({"mount", "Mount", "Pose of the sonar on the body that the trajectory moves"}, sonar.mount);
  const FieldReader* reader = f.reader();
  if (reader == nullptr) return;
  if (preset && watch.is_well()) {
    follow_preset(*preset, sonar);
  }
  check_band(reader->faults(), reader->map(), sonar);
  check_pulse_band(reader->faults(), reader->map(), sonar);
  check_ranges(reader->faults(), reader->map(), sonar);
}

void check_ping_size(Faults& faults, const Value& root, const Scenario& scenario) {
  const auto value = child(root, "sonar");
  if (!value) return;
  const SonarSpec& sonar = scenario.sonar;
  const double samples =
      std::ceil(sonar.bandwidth_hz * 2 * sonar.range_max_m / scenario.water.sound_speed_m_s);
  if (sonar.beam_count * samples > kMaxPixels) {
    add_fault(faults, value->place, value->path,
              fmt::format("{} beams of {} samples exceed 2^28 (268435456) samples per ping; "
                          "expected a lower beams.count, range_max_m or bandwidth_hz",
                          sonar.beam_count, samples));
  }
  const double rays = double{1} * sonar.beam_count * sonar.rays_elevation * sonar.rays_azimuth;
  if (rays > kMaxSonarRays) {
    add_fault(faults, value->place, value->path,
              fmt::format("{} beams of {} x {} rays exceed 2^27 (134217728) rays per ping; "
                          "expected a lower rays.elevation, rays.azimuth or beams.count",
                          sonar.beam_count, sonar.rays_elevation, sonar.rays_azimuth));
  }
}

void check_burst_length(Faults& faults, const Value& root, const Scenario& scenario) {
  const SonarSpec& sonar = scenario.sonar;
  const auto value = child(root, "sonar");
  if (!value || sonar.pulse.shape != PulseShape::cw || sonar.range_max_m == 0) return;
  const double record_s = 2 * sonar.range_max_m / scenario.water.sound_speed_m_s;
  if (sonar.pulse.duration_s <= record_s * (1 + kRounding)) return;
  // The duration may come from a preset, which is not in this tree.
  const auto duration = duration_in(*value);
  const Value& culprit = duration ? *duration : *value;
  add_fault(faults, culprit.place, culprit.path,
            fmt::format("a burst of {} s is longer than the record of {:.4g} s (2 range_max_m / "
                        "sound speed); expected a shorter one",
                        sonar.pulse.duration_s, record_s));
}

Sonar sonar_of(const Scenario& scenario) {
  const SonarSpec& spec = scenario.sonar;
  Sonar sonar;
  sonar.frequency_hz = spec.frequency_hz;
  sonar.bandwidth_hz = spec.bandwidth_hz;
  sonar.pulse.shape = spec.pulse.shape;
  sonar.pulse.duration_s = spec.pulse.duration_s;
  sonar.pulse.taper = spec.pulse.taper;
  sonar.window = spec.window;
  sonar.shading = spec.shading;
  sonar.transmit_width_rad = radians(spec.transmit_width_deg.value_or(0));
  sonar.adc = spec.adc;
  sonar.detector = spec.detector;
  if (spec.transmit) {
    sonar.transmit = spec.transmit->groups;
    sonar.transmit->interval_s = spec.transmit->interval_s.value_or(0);
    sonar.transmit->width_rad = radians(spec.transmit->width_deg.value_or(0));
  }
  if (spec.electronics) {
    sonar.front_end = spec.electronics->front_end;
    if (auto& other = sonar.front_end->interference) {
      other->azimuth_rad = radians(spec.electronics->interference_azimuth_deg);
    }
  }
  sonar.source_level_db = spec.source_level_db;
  sonar.range_min_m = spec.range_min_m;
  sonar.range_max_m = spec.range_max_m;
  sonar.beam_count = spec.beam_count;
  sonar.beam_spacing_rad = radians(spec.beam_fov_deg) / spec.beam_count;
  for (const double azimuth : spec.azimuths_deg) sonar.azimuth_rad.push_back(radians(azimuth));
  sonar.beam_width_rad = radians(spec.beam_width_deg);
  for (const double width : spec.receive_widths_deg) sonar.width_rad.push_back(radians(width));
  sonar.elevation_width_rad = radians(spec.elevation_width_deg);
  sonar.elevation_line.shading = spec.elevation_shading;
  sonar.elevation_fan_rad = radians(spec.elevation_fan_deg);
  sonar.rays_elevation = spec.rays_elevation;
  sonar.rays_azimuth = spec.rays_azimuth;
  sonar.rays_per_cell = spec.rays_per_cell;
  sonar.normalization = scenario.scattering.normalization;
  return sonar;
}

}  // namespace ensonify
