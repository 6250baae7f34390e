// The results of a ping and the properties of a sequence and a data set: records that the pipeline
// fills and dataset/ writes to disk.
//
//   LabelledImage                         one image and its labels (core/image_planes.h)
//   FrontView  CameraView                   the first surfaces in each direction, or pixel
//   GreyImage  PixelMask  InstanceMeasures  Annotation
//   Layer  LayerSeries                     signal components of a time series
//   FiredGroup  PingResult                 everything of one ping
//   OrientedBox  Instance  CartesianGrid  DrawnValue  Placement  ClassKind  Recording
//   InstrumentKind  SequenceInfo
//   what the pings of a sequence share
#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/display.h"
#include "core/elastic.h"
#include "core/image_planes.h"
#include "core/navigation.h"
#include "core/outputs.h"
#include "core/samples.h"
#include "core/scatterers.h"
#include "core/sonar.h"
#include "core/surface.h"
#include "core/units.h"
#include "core/vec.h"

namespace ensonify {

// Directions of a ping whose points make covisibility, in azimuth and elevation.
inline constexpr int kCovisibilityColumns = 32, kCovisibilityRows = 16;

// Largest number of pings of a sequence: file names have six digits for them.
inline constexpr int kMaxPings = 1'000'000;

// An image with its ground truth, [rows x columns].
// Polar: rows are samples, nearest first; columns are beams, 0 first.
// Cartesian: the fan seen from above, boresight up, port left.
struct LabelledImage : ImagePlanes {
  int rows = 0, columns = 0;
};

// The surface that each ray of the fan meets first, row-major [elevations x azimuths]: lowest
// elevation and beam 0 first. core/front_planes.h lists the values by name.
struct FrontView {
  int rows = 0, columns = 0;
  std::vector<float> range_m;                       // NaN: none
  std::vector<float> normal_x, normal_y, normal_z;  // unit length, sonar frame, towards the sonar
  std::vector<float> backscatter_db;    // dB re 1 m^2/m^2; kNoEnergyDb: scatters nothing
  std::vector<std::uint16_t> instance;  // 0: none
  std::vector<std::uint8_t> semantic;   // class id; 0: none
};

// The surface that each pixel of a camera shows, row-major [rows x columns], top row first.
// core/camera_planes.h lists the values by name.
struct CameraView {
  int rows = 0, columns = 0;
  std::vector<float> depth_m;                       // NaN: none
  std::vector<float> normal_x, normal_y, normal_z;  // unit length, camera frame, toward the camera
  std::vector<std::uint16_t> instance;              // 0: none
  std::vector<std::uint8_t> semantic;               // class id; 0: none
  std::vector<std::uint8_t> color;                  // [rows x columns x 3], sRGB
  std::vector<float> flow_x_px, flow_y_px;          // to the next ping; NaN: none
};

struct GreyImage {
  int rows = 0, columns = 0;
  std::vector<std::uint8_t> pixels;
};

// Some pixels of an image. COCO conventions: x, y, width, height in pixels; the counts of the
// column-major run-length code, compressed as COCO's tools do.
struct PixelMask {
  std::array<int, 4> box{};
  std::int64_t area = 0;
  std::string rle_counts;
};

// Measures of an instance in a ping, the same for all images; NaN if undefined.
struct InstanceMeasures {
  double truncated = std::numeric_limits<double>::quiet_NaN();    // share of its surface
  double contrast_db = std::numeric_limits<double>::quiet_NaN();  // over the ground around it
};

// One instance in one image.
struct Annotation {
  std::uint16_t instance = 0;
  std::array<int, 4> box{};
  std::int64_t area = 0;
  std::string rle_counts;
  // The pixels that the instance would have if everything else were transparent; absent if not
  // requested. If requested, `occlusion` is the share of its rays that meet another instance first;
  // NaN if no ray meets it.
  std::optional<PixelMask> amodal = {};
  double occlusion = 0;
  InstanceMeasures measures = {};
};

// Signal components, whose sum is the time series. `target`: the chosen instances; `background`:
// all other surfaces and point targets; `volume`: water, its volumes and their fish; `multipath`:
// all echoes over specular reflectors, which the other components do not contain; `quantisation`:
// the ADC's rounding error; `electronics`: what Sonar::front_end adds to the sum of all others.
enum class Layer { noise, volume, target, background, multipath, quantisation, electronics };
constexpr const char* layer_name(Layer layer) {
  constexpr const char* kNames[] = {"noise",     "volume",       "target",     "background",
                                    "multipath", "quantisation", "electronics"};
  return kNames[static_cast<int>(layer)];
}

struct LayerSeries {
  Layer layer = Layer::noise;
  Series pressure_pa;  // [beams x samples]
};

// What a recorder stores of a ping.
struct RecordedPing {
  std::vector<std::uint8_t> counts_8;    // [samples x beams] of 8 bits; empty: 16 bits
  std::vector<std::uint16_t> counts_16;  // ... of 16 bits; empty: 8 bits
  std::vector<float> row_gain;           // power gain of each sample; empty: none
};

// A group of beams that transmits by itself, in a ping.
struct FiredGroup {
  double time_s = 0;
  double level_db = 0;  // of its transmission, relative to the source level
  Pose sonar_in_world;  // at its transmission
};

struct PingResult {
  std::uint32_t ping = 0;
  double time_s = 0;
  Pose sonar_in_world;                  // with the mount
  std::vector<Pose> object_in_world;    // by instance id - 1
  std::vector<FiredGroup> groups = {};  // of Sonar::transmit; empty without
  Series series;                        // [beams x samples], Pa; empty: nothing needs it
  SampleArray<float> detected_db = {};  // [samples x beams], of Sonar::detector where there
                                        // are no images; empty: no detector
  std::vector<LayerSeries> layers;      // as SequenceInfo::layers
  RecordedPing recorded = {};           // as SequenceInfo::recorder
  Series channels;                      // [elements x samples], Pa; empty: not asked for
  std::optional<LabelledImage> polar;   // absent: not asked for
  std::optional<LabelledImage> cartesian;
  std::optional<FrontView> front = {};
  std::optional<CameraView> camera = {};
  std::vector<ElevationEcho> elevation = {};  // as labels/elevation.h; empty: not asked for
  std::optional<GreyImage> polar_grey;
  std::optional<GreyImage> cartesian_grey;
  DisplayCounts grey_counts;  // of polar_grey
  std::vector<Annotation> polar_annotations;
  std::vector<Annotation> cartesian_annotations;
  std::vector<Annotation> polar_hidden;  // fully hidden instances: only amodal masks
  std::vector<Annotation> cartesian_hidden;
  std::vector<float> first_return_m;            // [beams], NaN: none
  ScattererList scatterers;                     // with amplitudes as drawn, for the export
  std::vector<std::complex<float>> amplitudes;  // [scatterers]; empty: export not asked for
};

// A box around a whole instance: of an object in its own frame, of a volume in the world frame.
struct OrientedBox {
  Pose pose;    // of its center
  Vec3 size_m;  // along its own axes
};

enum class InstanceKind { surface, point_target, volume };

// A part of a surface that has its own material, by its name in the file.
struct InstancePart {
  std::string name;
  std::string material;
  Material scattering;
};

// Patches of a surface with another material.
struct InstanceGrowth {
  std::string on;        // the material that it grows on
  std::string material;  // what has grown
  Material scattering;
  double cover = 0, correlation_m = 0;
};

struct Instance {
  std::uint16_t id = 0;  // 1, 2, ...: objects as in the scenario, then point targets, then volumes
  std::string name;
  std::uint8_t class_id = 0;
  std::string class_name;
  InstanceKind kind = InstanceKind::surface;
  std::string material;                  // of a surface, by name
  Material scattering;                   // of a surface
  bool vertex_reflectivity = false;      // of a surface: its mesh scales the reflectivity
  bool image_reflectivity = false;       // of a surface: an image on its mesh does
  double target_strength_db = 0;         // of a point target; of a sphere, at the carrier
  double volume_strength_db = 0;         // of a volume, dB re 1/m
  SurfaceTexture volume_patches = {};    // of a volume: factor on its density
  std::vector<InstancePart> parts = {};  // of a surface: parts with another material
  std::vector<InstanceGrowth> growth = {};
  std::optional<OrientedBox> box = {};      // absent: a point, or infinite
  std::optional<ElasticBody> elastic = {};  // of a sphere or cylinder with resonances
};

// The Cartesian image: pixel (row, column) has its center at
// x = x_top_m - (row + 1/2) m_per_px, y = y_left_m - (column + 1/2) m_per_px in the sonar's plane.
struct CartesianGrid {
  int height_px = 0, width_px = 0;
  double m_per_px = 0;
  double x_top_m = 0, y_left_m = 0;
};

// The signed distance field of the scene: cubic voxels, with distances on either side of surfaces.
struct SdfGrid {
  double voxel_m = 0;
  int band_voxels = 3;
};

// Triangles of spheres and cylinders in world meshes lie at most this share of the radius inside.
inline constexpr double kChordOfRadius = 1e-3;

// Heights of the scene on a grid over the world: row r, column c lies at
// x = x_west_m + c spacing_m, y = y_north_m - r spacing_m.
struct HeightMap {
  double spacing_m = 0;
  int rows = 0, columns = 0;
  double x_west_m = 0, y_north_m = 0;
};

// A sampled value of the scenario: its key path, with list items by name, and the value as YAML.
// For a choice among maps, lists or files: the path with `.choice` appended and the number of the
// alternative, from 0.
struct DrawnValue {
  std::string path;  // objects.rock_3.pose.position_m.0
  std::string value;
  friend bool operator==(const DrawnValue&, const DrawnValue&) = default;
};

// The outcome of placing objects at random in a sequence. Repeated sampling favors sequences with
// few or small objects, and the counts show by how much.
struct PlacedClass {
  std::string class_name;
  std::uint64_t first = 0;  // objects to be placed in the first sample
  std::uint64_t kept = 0;   // ... in the sample that was kept, without those left out
};
struct Placement {
  std::uint32_t redraws = 0;  // before the sample that was kept
  std::vector<PlacedClass> classes;
  std::vector<std::string> left_out;  // names of objects
};

// COCO's kinds: countable things, and the stuff around them.
enum class ClassKind { thing, stuff };
inline const char* name_of(ClassKind kind) { return kind == ClassKind::stuff ? "stuff" : "thing"; }

// The log that a recorded sequence was read from.
struct Recording {
  std::string format;             // of the log: aris, oculus, mcap or images
  std::string file;               // its name, without the folder
  std::string sha256;             // ... and hash
  std::string instrument;         // as the log names it
  std::uint64_t serial = 0;       // of the instrument; 0: not in the log
  std::uint32_t mode = 0;         // the instrument's number of its mode
  std::uint64_t first_frame = 0;  // of the log: the frame of the sequence's first ping, from 0
  std::int64_t start_us = 0;      // of the instrument's clock, at time 0 of the sequence
};

enum class InstrumentKind { sonar, camera, navigation };
constexpr const char* name_of(InstrumentKind kind) {
  constexpr const char* kNames[] = {"sonar", "camera", "navigation"};
  return kNames[static_cast<int>(kind)];
}

struct SequenceInfo {
  // What is not a sonar has no beams and samples, and nothing that describes echoes.
  InstrumentKind instrument = InstrumentKind::sonar;
  std::optional<Pose> mount = {};  // on the body, of an instrument of a rig
  std::uint32_t sequence = 0;
  std::uint64_t seed = 0;
  std::optional<std::uint64_t> speckle_seed = {};  // of the scenario
  // Of an instrument of a rig, in place of `seed` for all but what lies on surfaces.
  std::optional<std::uint64_t> instrument_seed = {};
  std::string split;  // train, val or test
  Sonar sonar;
  double receive_aperture_wavelengths = 0;          // of the shaded line that has the beam's width
  std::vector<double> element_y_m, element_weight;  // of sonar.array, [elements]
  double processing_gain = 1;  // of the pulse: the noise's power is divided by it
  double pulse_extent_s = 0;   // T_p
  Water water;
  Record record;
  double synthesis_tolerance = 1e-5;
  SpeckleMode speckle = SpeckleMode::per_ping;
  bool motion_within_ping = false;
  std::optional<Recorder> recorder = {};  // absent: there are no counts
  bool noise_correlated = false;          // between beams, as they overlap
  std::optional<double> noise_spectrum_level_db;
  std::optional<double> noise_snr_db;  // against the mean clean power of ping 0
  double noise_power_pa2 = 0;          // E|p|^2 of the noise in every sample; 0: none
  std::optional<Multipath> multipath = {};
  int bounces = 0;                    // of the scenario
  std::vector<SoundPath> paths = {};  // of scatterers, by id
  std::vector<DrawnValue> draws;
  std::optional<Placement> placement = {};  // absent: nothing is placed at random
  std::vector<Instance> instances;
  std::vector<std::string> classes;               // class id k is classes[k - 1]
  std::optional<CartesianGrid> cartesian;         // absent: not asked for
  std::optional<SdfGrid> sdf = {};                // absent: not asked for
  std::optional<HeightMap> height_map = {};       // absent: not asked for
  std::optional<NavigationInfo> navigation = {};  // absent: no sensors
  std::optional<Camera> camera = {};              // absent: there is none, or no file of it
  Display png;                                    // of the 8-bit images
  DisplayCounts png_counts;                       // ... over all pings, once these are made
  OutputSelection output;
  std::vector<Layer> layers;  // those that the sequence can have; empty: not asked
  std::vector<std::uint16_t> target_instances;  // of the layer `target`, ascending
  std::uint32_t first_ping = 0, last_ping = 0;  // [first, last)
  std::optional<Recording> recording = {};      // absent: simulated
  // Of output.statistics: hashes of what realizations have in common, and of what its worlds have.
  std::string scene_sha256 = {}, scenario_sha256 = {};
};

inline bool is_sonar(const SequenceInfo& info) { return info.instrument == InstrumentKind::sonar; }

// Keys what belongs to the instrument alone.
inline std::uint64_t device_seed(const SequenceInfo& info) {
  return info.instrument_seed.value_or(info.seed);
}

}  // namespace ensonify
