#include "dataset/finish.h"

#include <fmt/format.h>

#include "core/units.h"
#include "dataset/catalogue.h"

namespace ensonify {
namespace {

std::string introduction(const DatasetInfo& info, std::uint64_t pings) {
  const SequenceInfo& first = info.first;
  const Sonar& sonar = first.sonar;
  return fmt::format(
      R"(# {name}

Simulated multibeam sonar data, made by ensonify {version}: {pings} pings in {sequences} sequence{s}.
Each ping is the coherent sum of the echoes of many scatterers, with speckle and side lobes as a real
instrument shows them, and comes with exact labels.

The sonar of sequence 0 (others may differ; `sequences/*/sequence.json` has the numbers of each):

| | |
|---|---|
| carrier, bandwidth | {f_c} Hz, {b} Hz |
| source level | {level} dB re 1 µPa·m |
| beams | {beams}, {spacing:.4g}° apart, {width:.4g}° wide |
| range | {near:.6g} m to {far:.6g} m, {samples} samples of {step:.4g} m |
| sound speed, absorption | {c} m/s{bent}, {alpha:.4g} dB/m |

)",
      fmt::arg("name", info.identity.name), fmt::arg("version", info.identity.program_version),
      fmt::arg("pings", pings), fmt::arg("sequences", info.sequences.size()),
      fmt::arg("s", info.sequences.size() == 1 ? "" : "s"), fmt::arg("f_c", sonar.frequency_hz),
      fmt::arg("b", sonar.bandwidth_hz), fmt::arg("level", sonar.source_level_db),
      fmt::arg("beams", sonar.beam_count), fmt::arg("spacing", degrees(sonar.beam_spacing_rad)),
      fmt::arg("width", degrees(sonar.beam_width_rad)), fmt::arg("near", sonar.range_min_m),
      fmt::arg("far", sonar.range_max_m), fmt::arg("samples", first.record.samples),
      fmt::arg("step", sample_range_m(sonar, first.water, 1)),
      fmt::arg("c", first.water.sound_speed_m_s),
      fmt::arg("bent", first.water.profile ? " on the range axis; in the water by the profile of "
                                             "`sequence.json`, which bends rays"
                                           : ""),
      fmt::arg("alpha", first.water.absorption_db_m));
}

std::string classes_table(const DatasetInfo& info) {
  std::string text = "Classes (0 is no object):\n\n| id | class | kind |\n|---|---|---|\n";
  for (std::size_t k = 0; k < info.classes.size(); ++k) {
    text += fmt::format("| {} | {} | {} |\n", k + 1, info.classes[k], name_of(info.class_kinds[k]));
  }
  return text + "\n";
}

constexpr char kConventions[] = R"(## Axes, units, order of beams

- Beam 0 looks to starboard (most negative azimuth); azimuth grows to port. `azimuth_rad.npy` has the
  beams' azimuths in radians, `range_m.npy` the samples' slant ranges in metres.
- World frame: x east, y north, z up. Sonar frame: x along the boresight, y to port, z up. Quaternions
  are w, x, y, z; poses place the sonar (its mount included) or an object in the world.
- The time series are complex baseband; |p| is rms pressure in pascal, and the carrier's phase is
  kept. A delay τ multiplies a spectrum by exp(−i 2π f τ).
- A level is 20 log10 |p| + 120, in dB re 1 µPa. Where there is no energy at all, levels are −99 dB
  and angles NaN.
- Polar pictures: rows are samples, nearest first; columns are beams, 0 first. Cartesian pictures: the
  fan seen from above, boresight up, port left, nearest neighbor but for those in `png/`; the headers
  and `sequence.json` give metres per pixel and where pixel (0, 0) lies.
- The grey pictures in `png/` are made of the level as `png` in `sequence.json` says: linear in dB
  between two limits, or in amplitude up to one, with a gain that may grow with range. Cartesian ones
  show the mean intensity over each pixel unless `resampling` is nearest. EXR pictures and series have
  no such gain.

)";

std::string row(bool wanted, const char* text) { return wanted ? std::string(text) + "\n" : ""; }

const char* layer_words(const SequenceInfo& info) {
  return info.multipath ? "noise, volume, target, background, multipath and quantisation"
                        : "noise, volume, target, background and quantisation";
}

std::string with_numbers(std::string line, const SequenceInfo& info) {
  const auto replace = [&](std::string_view mark, const std::string& text) {
    const auto at = line.find(mark);
    if (at != std::string::npos) line.replace(at, mark.size(), text);
  };
  replace("{layers}", layer_words(info));
  if (info.sdf) replace("{voxel_m}", fmt::format("{}", info.sdf->voxel_m));
  return line;
}

std::string file_rows(const SequenceInfo& info, FileScope scope) {
  const FileSelection selection = selection_of(info);
  std::string text;
  for (const CatalogueRow& entry : catalogue()) {
    const std::string line = info.output.packed ? entry.packed_card : entry.card;
    const bool wanted = entry.layer ? info.output.layers : is_wanted(entry, selection);
    if (entry.scope == scope && wanted)
      text += row(!line.empty(), with_numbers(line, info).c_str());
  }
  return text;
}

std::string files_table(const SequenceInfo& first) {
  const char* head = "| file | what |\n|---|---|\n";
  return std::string("## Files\n\n") + head + file_rows(first, FileScope::dataset) +
         "\nIn each folder `sequences/SSSSSS/`, PPPPPP being the ping:\n\n" + head +
         file_rows(first, FileScope::sequence) +
         (first.output.packed
              ? std::string("\nArrays hold all pings of the sequence, in the order of "
                            "`poses.csv`; `arrays` in\n`sequence.json` has their shapes:\n\n") +
                    head
              : "") +
         file_rows(first, FileScope::ping) + "\n";
}

constexpr char kPackedLoading[] = R"(Without it:

```python
import glob, json
import numpy as np

for folder in sorted(glob.glob("sequences/*")):
    about = json.load(open(f"{folder}/sequence.json"))
    arrays = {name: np.load(f"{folder}/{name}", mmap_mode="r") for name in about["arrays"]}
    first = about["pings"][0]            # row 0 of every array; ping p is row p - first

coco = json.load(open("coco.json"))      # its images name an `array` and an `index` in it
```

`ensonify verify` checks every file; without it, `sha256sum -c dataset.sha256` and the hashes in
`dataset.json` and `sequence.json` do.

)";

std::string loading_by_reader(const OutputSelection& output) {
  std::string code = R"(## Loading

With the reader that comes with ensonify (the folder `scripts/ensonify_dataset` of its source, NumPy
only, to copy beside your own code; a PyTorch `Dataset` is in it):

```python
from ensonify_dataset import SonarDataset

data = SonarDataset(".")                        # this folder
for ping in data.split("train"):                # or data[0, 3]: sequence 0, ping 3
)";
  code += row(output.polar, "    level_db, mask = ping.polar.level_db, ping.polar.instance");
  code +=
      row(output.timeseries, "    series = ping.series                        # [beams, samples]");
  code += row(
      output.statistics,
      "    contrast = ping.sequence.statistics.contrast   # [samples, beams], of all its pings");
  return code + R"(    azimuth_rad = ping.sequence.azimuth_rad
```

)";
}

std::string loading(const SequenceInfo& info) {
  if (info.output.packed) {
    return loading_by_reader(info.output) + kPackedLoading;
  }
  std::string code = loading_by_reader(info.output) + R"(Without it:

```python
import csv, json, os
os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"    # before cv2 is imported
import cv2, numpy as np

for row in csv.DictReader(open("index.csv")):
    sequence, ping = row["stem"].split("/")
    folder = "sequences/" + sequence
)";
  const OutputSelection& output = info.output;
  const auto line = [&](bool wanted, const char* text) {
    if (wanted) code += std::string("    ") + text + "\n";
  };
  line(output.timeseries,
       R"(series = np.load(f"{folder}/timeseries/{ping}.npy")      # [beams, samples])");
  line(output.polar,
       R"(level_db = cv2.imread(f"{folder}/polar/{ping}.exr", cv2.IMREAD_UNCHANGED))");
  line(output.polar,
       R"(instance = cv2.imread(f"{folder}/polar/{ping}_instance.png", cv2.IMREAD_UNCHANGED))");
  line(output.png && output.polar,
       R"(grey = cv2.imread(f"{folder}/png/{ping}_polar.png", cv2.IMREAD_UNCHANGED))");
  line(output.scatterers,
       R"(scatterers = np.load(f"{folder}/scatterers/{ping}.npy")  # one record each)");
  line(
      output.statistics,
      R"(contrast = np.load(f"{folder}/statistics/contrast.npy")  # [samples, beams], of all pings)");
  line(true, R"(azimuth_rad = np.load(f"{folder}/azimuth_rad.npy"))");
  return code + R"(
coco = json.load(open("coco.json"))
```

`ensonify verify` checks every file; without it, `sha256sum -c dataset.sha256` and the hashes in
`dataset.json` and `sequence.json` do.

)";
}

constexpr char kLicence[] = R"(## Licence

The program that made these data claims no rights in them: whoever generated them decides. Meshes and
other input files in `assets/` keep the licences of their authors; see to those before you pass the
data on.
)";

}  // namespace

std::string data_card(const DatasetInfo& info, std::uint64_t pings) {
  const SequenceInfo& first = info.first;
  return introduction(info, pings) + classes_table(info) + kConventions + files_table(first) +
         loading(first) + kLicence;
}

}  // namespace ensonify
