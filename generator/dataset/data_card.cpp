#include "dataset/data_card.h"

#include <fmt/format.h>

#include "core/units.h"

namespace ensonify {
namespace {

std::uint64_t ping_count(const DatasetInfo& info) {
  std::uint64_t count = 0;
  for (const SequenceInfo& sequence : info.sequences) {
    count += sequence.last_ping - sequence.first_ping;
  }
  return count;
}

std::string introduction(const DatasetInfo& info) {
  const SequenceInfo& first = info.sequences.front();
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
      fmt::arg("pings", ping_count(info)), fmt::arg("sequences", info.sequences.size()),
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
  std::string text = "Classes (0 is no object):\n\n| id | class |\n|---|---|\n";
  for (std::size_t k = 0; k < info.classes.size(); ++k) {
    text += fmt::format("| {} | {} |\n", k + 1, info.classes[k]);
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
  fan seen from above, boresight up, port left, nearest neighbour; the headers and `sequence.json`
  give metres per pixel and where pixel (0, 0) lies.
- The grey pictures in `png/` are made of the level as `png` in `sequence.json` says: linear in dB
  between two limits, or in amplitude up to one, with a gain that may grow with range. EXR pictures and
  series have no such gain.

)";

std::string row(bool wanted, const char* text) { return wanted ? std::string(text) + "\n" : ""; }

const char* layer_words(const SequenceInfo& info) {
  return info.multipath ? "noise, volume, target, background, multipath and quantisation"
                        : "noise, volume, target, background and quantisation";
}

// Arrays of all pings.
std::string packed_rows(const SequenceInfo& info) {
  const OutputSelection& output = info.output;
  std::string text =
      "\nArrays hold all pings of the sequence, in the order of `poses.csv`; `arrays` in\n"
      "`sequence.json` has their shapes:\n\n| file | what |\n|---|---|\n";
  text += row(output.timeseries, "| `timeseries.npy` | complex64 [pings, beams, samples], Pa |");
  text +=
      row(output.channels,
          "| `channels.npy` | complex64 [pings, elements, samples], Pa: what each element of the "
          "array hears |");
  if (output.layers) {
    text += fmt::format(
        "| `layers_*.npy` | the same of {}, as far as there are any; their sum is "
        "the series |\n",
        layer_words(info));
  }
  text += row(output.polar,
              "| `polar_level_db.npy` | float16 [pings, samples, beams], level in dB; likewise "
              "`polar_clean_db`, `polar_elevation_rad`, `polar_elevation_std_rad`, "
              "`polar_instance_fraction` |");
  text +=
      row(output.polar,
          "| `polar_instance.npy`, `polar_semantic.npy` | exact ids, uint16 and uint8, 0: none |");
  text += row(output.polar && output.multipath,
              "| `polar_multipath.npy` | uint16, the instance whose echoes over mirrors are more "
              "than the direct ones, 0: none; no other mask counts such echoes |");
  text += row(output.cartesian,
              "| `cartesian_*.npy` | the same, [pings, rows, columns], seen from above |");
  text += row(output.png, "| `polar_grey.npy`, `cartesian_grey.npy` | uint8 grey |");
  return text + row(output.scatterers,
                    "| `scatterers/PPPPPP.npy` | structured array of every scatterer of a ping |");
}

// With a file for each ping.
std::string ping_rows(const SequenceInfo& first) {
  const OutputSelection& output = first.output;
  std::string text =
      row(output.timeseries, "| `timeseries/PPPPPP.npy` | complex64 [beams, samples], Pa |");
  text += row(output.timeseries_exr,
              "| `timeseries/PPPPPP.exr` | the series as a picture: rows samples, columns beams, "
              "float channels `p.re` and `p.im`, Pa |");
  text +=
      row(output.channels,
          "| `channels/PPPPPP.npy` | complex64 [elements, samples], Pa: what each element of the "
          "array hears |");
  if (output.layers) {
    text += fmt::format(
        "| `layers/PPPPPP_*.npy` | complex64 [beams, samples], Pa: {}, as far as "
        "there are any; their sum is the series |\n",
        layer_words(first));
  }
  text += row(output.polar,
              "| `polar/PPPPPP.exr` | level in dB (`Y`); second part: clean level, "
              "elevation and its spread, share of the winning instance |");
  text += row(output.polar,
              "| `polar/PPPPPP_instance.png`, `polar/PPPPPP_semantic.png` | exact ids, "
              "16 and 8 bit, 0: none |");
  text += row(output.polar && output.shadow,
              "| `polar/PPPPPP_shadow.png` | 16 bit, the instance in whose shadow the pixel lies, "
              "0: none |");
  text +=
      row(output.polar && output.multipath,
          "| `polar/PPPPPP_multipath.png` | 16 bit, the instance whose echoes over mirrors are "
          "heard there, where they are more than the direct ones, 0: none; no other mask counts "
          "such echoes |");
  text += row(output.cartesian, "| `cartesian/PPPPPP*` | the same, seen from above |");
  text += row(output.png, "| `png/PPPPPP_polar.png`, `png/PPPPPP_cartesian.png` | 8-bit grey |");
  text += row(output.scatterers,
              "| `scatterers/PPPPPP.npy` | structured array of every scatterer; "
              "with `model` in `sequence.json` it gives the series again |");
  text += row(output.points, "| `points/PPPPPP.ply` | the same as a point cloud in the world |");
  return text;
}

std::string files_table(const SequenceInfo& first) {
  std::string text = R"(## Files

| file | what |
|---|---|
| `dataset.json` | manifest with the SHA-256 of the files; its own is in `dataset.sha256` |
| `work.json` | what was generated: scenario, seed, program and numerics |
| `scenario.yaml`, `assets/` | the scenario as resolved and the input files it names; running it again gives the same bytes |
| `index.csv` | one row a ping: sequence, ping, time_s, split, stem |
| `splits/*.txt` | the stems (`sequence/ping`) of each split, whole sequences together |
| `coco.json` | boxes and masks (compressed RLE) of every instance in every picture; with `amodal_segmentation` also of what is hidden of it, and `occlusion`, the share that is |
| `provenance.json` | host, wall time, threads: not part of the data |

In each folder `sequences/SSSSSS/`, PPPPPP being the ping:

| file | what |
|---|---|
| `sequence.json` | the sequence as drawn: sonar, water, instances, model, every file with its SHA-256 |
| `azimuth_rad.npy`, `range_m.npy` | float64, the axes |
| `poses.csv`, `poses.tum` | the sonar's pose at each ping |
| `objects.csv` | the pose of each object at each ping |
| `boxes.csv` | the 3-D box of each instance at each ping, in the world and in the sonar's frame |
| `first_return_m.npy` | float32 [pings, beams], range of the first echo, NaN where there is none |
| `annotations.jsonl` | boxes and masks by ping, from which `coco.json` is made |
)";
  if (first.sdf) {
    text += fmt::format(
        "| `sdf.vdb` | OpenVDB level set `sdf` of the scene at the first ping: signed distances in "
        "metres, voxels of {} m, world coordinates |\n",
        first.sdf->voxel_m);
  }
  text +=
      row(first.output.statistics,
          "| `statistics/*.npy` | float64 or complex128 [samples, beams]: mean, variance, "
          "contrast, fourth moment and covariance of neighbours over all pings, which are draws "
          "of one scene; `statistics` in `sequence.json` says each |");
  text += first.output.packed ? packed_rows(first) : ping_rows(first);
  return text + "\n";
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

std::string data_card(const DatasetInfo& info) {
  const SequenceInfo& first = info.sequences.front();
  return introduction(info) + classes_table(info) + kConventions + files_table(first) +
         loading(first) + kLicence;
}

}  // namespace ensonify
