// One file: one group per sequence with its arrays stacked over pings or, with --stack, also the
// arrays of all sequences at the root, stacked over all pings.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "core/counted.h"
#include "dataset/read_pictures.h"
#include "export/file_module.h"
#include "export/job.h"
#include "formats/exr.h"
#include "formats/npy.h"
#include "formats/png.h"

namespace ensonify {
namespace {

// Extents of the arrays of a sequence, or of the largest ones of several.
struct Extents {
  std::uint64_t beams = 0, samples = 0, elements = 0, cartesian_height = 0, cartesian_width = 0,
                elevations = 0, azimuths = 0, instances = 0, camera_height = 0, camera_width = 0;
  friend bool operator==(const Extents&, const Extents&) = default;

  GridSizes sizes() const {
    return {.beams = beams,
            .samples = samples,
            .elements = elements,
            .cartesian_height = cartesian_height,
            .cartesian_width = cartesian_width,
            .elevations = elevations,
            .azimuths = azimuths,
            .camera_height = camera_height,
            .camera_width = camera_width};
  }
};

Extents extents_of(const StoredSequence& s) {
  const GridSizes sizes = s.sizes();
  return {s.beams,
          s.samples,
          s.elements,
          s.cartesian_height,
          s.cartesian_width,
          s.ray_elevations,
          s.ray_azimuths,
          s.instances.size(),
          sizes.camera_height,
          sizes.camera_width};
}

Extents larger(const Extents& a, const Extents& b) {
  return {std::max(a.beams, b.beams),
          std::max(a.samples, b.samples),
          std::max(a.elements, b.elements),
          std::max(a.cartesian_height, b.cartesian_height),
          std::max(a.cartesian_width, b.cartesian_width),
          std::max(a.elevations, b.elevations),
          std::max(a.azimuths, b.azimuths),
          std::max(a.instances, b.instances),
          std::max(a.camera_height, b.camera_height),
          std::max(a.camera_width, b.camera_width)};
}

// Cells of each ping, except lists, whose length varies, and time series as EXR, which are exported
// as arrays.
bool is_exported(const CatalogueRow& row) { return row.cells && !row.array.empty(); }

// timeseries, channels, layers/noise, polar/level_db, polar/grey, front/range_m
std::string array_name(const CatalogueRow& row) {
  if (row.front_plane != nullptr) return std::string("front/") + row.front_plane->name;
  if (row.camera_plane != nullptr) return std::string("camera/") + row.camera_plane->name;
  if (row.layer) return std::string("layers/") + layer_name(*row.layer);
  if (!row.view) return row.array.substr(0, row.array.find('.'));
  return std::string(view_name(*row.view)) + "/" +
         (row.plane != nullptr ? row.plane->name : "grey");
}

Hdf5Type array_type(const CatalogueRow& row) {
  if (row.type == kNpyComplex64) return Hdf5Type::complex64;
  if (row.type == kNpyFloat16) return Hdf5Type::f16;
  if (row.type == kNpyFloat32) return Hdf5Type::f32;
  return row.type == kNpyUint16 ? Hdf5Type::u16 : Hdf5Type::u8;
}

Hdf5Fill array_fill(const CatalogueRow& row) {
  const PlaneBlank blank = plane_facts(row).blank;
  if (blank == PlaneBlank::no_energy) return Hdf5Fill::no_energy;
  return blank == PlaneBlank::nan ? Hdf5Fill::nan : Hdf5Fill::zero;
}

std::vector<std::string> array_axes(const CatalogueRow& row) {
  switch (row.grid) {
    case FileGrid::series:
      return {"", "azimuth_rad", "range_m"};
    case FileGrid::channels:
      return {"", "", "range_m"};
    case FileGrid::polar:
      return {"", "range_m", "azimuth_rad"};
    case FileGrid::front:
      return {"", "front_elevation_rad", "front_azimuth_rad"};
    default:
      return {};
  }
}

// The path of a sequence's own group.
std::string group_of(const StoredSequenceRow& row) {
  return fmt::format("/sequences/{:06}", row.sequence);
}

// The arrays of one or all sequences, below `base`, with one row per ping.
class Stack {
 public:
  // Axes have names if all rows share them.
  Stack(Hdf5File& file, std::string base, std::uint64_t rows, const Extents& extents, bool has_axes)
      : file_(file), base_(std::move(base)), rows_(rows), extents_(extents), has_axes_(has_axes) {}

  void make(const StoredSequence& sequence) {
    add("sequence", Hdf5Type::u32, {}, "");
    add("ping", Hdf5Type::u32, {}, "");
    add("time_s", Hdf5Type::f64, {}, "s");
    add("sonar_position_m", Hdf5Type::f64, {3}, "m, world: x east, y north, z up");
    add("sonar_quaternion_wxyz", Hdf5Type::f64, {4}, "sonar to world");
    const std::uint64_t n = extents_.instances;
    add("object_position_m", Hdf5Type::f64, {n, 3}, "m, world; row k is instance k + 1",
        Hdf5Fill::nan);
    add("object_quaternion_wxyz", Hdf5Type::f64, {n, 4}, "object to world; row k is instance k + 1",
        Hdf5Fill::nan);
    add("first_return_m", Hdf5Type::f32, {extents_.beams}, "m", Hdf5Fill::nan, {"", "azimuth_rad"});
    for (const CatalogueRow& row : catalogue()) {
      if (!is_exported(row) || !can_read(sequence, row)) continue;
      const bool is_pressure = row.grid == FileGrid::series || row.grid == FileGrid::channels;
      const char* unit = is_pressure ? "Pa (rms)" : plane_facts(row).unit;
      add(array_name(row), array_type(row), grid_shape(row, extents_.sizes()), unit,
          array_fill(row), array_axes(row));
    }
  }

  Status write(const ExportJob& job, const StoredSequence& sequence, const StoredPing& ping,
               std::uint64_t row) {
    write_poses(sequence, ping, row);
    const auto first_return = stored_file(job.dataset, sequence.row.sequence, "first_return_m.npy");
    if (!first_return) return first_return.error();
    const auto returns =
        read_npy_row(*first_return, kNpyFloat32, {sequence.row.pings(), sequence.beams},
                     ping.ping - sequence.row.first_ping);
    if (!returns) return returns.error();
    put("first_return_m", row, returns->data(), {sequence.beams});
    CellReader reader(job.dataset, sequence, ping.ping);
    for (const CatalogueRow& cells : catalogue()) {
      if (!is_exported(cells) || !can_read(sequence, cells)) continue;
      const auto bytes = reader.read(cells);
      if (!bytes) return bytes.error();
      put(array_name(cells), row, bytes->data(), grid_shape(cells, sequence.sizes()));
    }
    return {};
  }

 private:
  void add(const std::string& name, Hdf5Type type, std::vector<std::uint64_t> shape,
           const char* units, Hdf5Fill fill = Hdf5Fill::zero, std::vector<std::string> axes = {}) {
    shape.insert(shape.begin(), rows_);
    Hdf5ArraySpec spec{base_ + "/" + name, type, std::move(shape), false, fill, {}, {}};
    spec.deflate = type == Hdf5Type::u8 || type == Hdf5Type::u16;
    if (*units != '\0') spec.attributes.push_back({"units", units});
    for (std::string& axis : axes) {
      if (has_axes_) spec.axes.push_back(axis.empty() ? axis : base_ + "/" + axis);
    }
    file_.make_array(spec);
  }
  void put(const std::string& name, std::uint64_t row, const void* data,
           const std::vector<std::uint64_t>& shape) {
    file_.write_row(base_ + "/" + name, row, data, shape);
  }

  void write_poses(const StoredSequence& sequence, const StoredPing& ping, std::uint64_t row) {
    const std::size_t n = sequence.instances.size();
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> positions(3 * n, kNone), quaternions(4 * n, kNone);
    const auto fill = [](const Pose& pose, double* position, double* quaternion) {
      const auto& [p, q] = pose;
      std::copy_n(std::initializer_list<double>{p.x, p.y, p.z}.begin(), 3, position);
      std::copy_n(std::initializer_list<double>{q.w, q.x, q.y, q.z}.begin(), 4, quaternion);
    };
    for (const StoredObjectPose& object : ping.objects) {
      const std::size_t k = object.instance - 1;
      fill(object.in_world, positions.data() + 3 * k, quaternions.data() + 4 * k);
    }
    double position[3], quaternion[4];
    fill(ping.sonar_in_world, position, quaternion);
    put("sequence", row, &sequence.row.sequence, {});
    put("ping", row, &ping.ping, {});
    put("time_s", row, &ping.time_s, {});
    put("sonar_position_m", row, position, {3});
    put("sonar_quaternion_wxyz", row, quaternion, {4});
    if (n == 0) return;
    put("object_position_m", row, positions.data(), {n, 3});
    put("object_quaternion_wxyz", row, quaternions.data(), {n, 4});
  }

  Hdf5File& file_;
  std::string base_;
  std::uint64_t rows_;
  Extents extents_;
  bool has_axes_;
};

Status write_axis(const ExportJob& job, Hdf5File& file, const StoredSequence& sequence,
                  const char* name, const char* units, std::uint64_t count) {
  const auto path = stored_file(job.dataset, sequence.row.sequence, std::string(name) + ".npy");
  if (!path) return path.error();
  const auto axis = read_npy(*path, kNpyFloat64, {count});
  if (!axis) return axis.error();
  const std::string array = group_of(sequence.row) + "/" + name;
  file.make_array({array, Hdf5Type::f64, {count}, false, Hdf5Fill::zero, {{"units", units}}, {}});
  file.write_all(array, axis->data().data());
  return {};
}

// Arrays that a sequence has once, whether or not its pings are stacked with others.
Status write_sequence_group(const ExportJob& job, Hdf5File& file, const StoredSequence& sequence) {
  const std::string group = group_of(sequence.row);
  file.set_number(group, "sequence", std::uint64_t{sequence.row.sequence});
  file.set_number(group, "seed", sequence.seed);
  file.set_text(group, "split", sequence.row.split);
  file.set_number(group, "frequency_hz", sequence.frequency_hz);
  file.set_number(group, "sound_speed_m_s", sequence.sound_speed_m_s);
  if (sequence.cartesian_height > 0) {
    file.set_number(group, "cartesian_metres_per_pixel", sequence.metres_per_pixel);
  }
  std::vector<std::string> names;
  std::vector<std::uint8_t> class_ids;
  for (const StoredInstance& instance : sequence.instances) {
    names.push_back(instance.name);
    class_ids.push_back(instance.class_id);
  }
  file.write_texts(group + "/instance_name", names);
  file.make_array({group + "/instance_class_id",
                   Hdf5Type::u8,
                   {class_ids.size()},
                   false,
                   Hdf5Fill::zero,
                   {},
                   {}});
  if (!class_ids.empty()) file.write_all(group + "/instance_class_id", class_ids.data());
  const Status azimuths =
      write_axis(job, file, sequence, "azimuth_rad", "rad, positive to port", sequence.beams);
  if (!azimuths) return azimuths;
  const Status ranges = write_axis(job, file, sequence, "range_m", "m", sequence.samples);
  if (!ranges || !sequence.manifest.info.output.front) return ranges;
  const Status elevations = write_axis(job, file, sequence, "front_elevation_rad",
                                       "rad, positive up", sequence.ray_elevations);
  return elevations ? write_axis(job, file, sequence, "front_azimuth_rad", "rad, positive to port",
                                 sequence.ray_azimuths)
                    : elevations;
}

struct StackPlan {
  Extents extents;
  std::uint64_t rows = 0;
};

std::string in_words(const Extents& e) {
  return fmt::format("{}, {}, {} x {} Cartesian pixels, {}", counted(e.beams, "beam"),
                     counted(e.samples, "sample"), e.cartesian_width, e.cartesian_height,
                     counted(e.instances, "instance"));
}

Result<StackPlan> plan_stack(const ExportJob& job) {
  StackPlan plan;
  std::optional<StoredSequence> first;
  const Status read = for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    const Extents extents = extents_of(sequence);
    if (first && sequence.each_ping != first->each_ping) {
      return Error{
          ErrorKind::usage,
          fmt::format("sequences {} and {} have different kinds of files: --stack cannot put "
                      "them into one array; run the command without it",
                      first->row.sequence, sequence.row.sequence)};
    }
    if (first && !job.options.pad && extents != extents_of(*first)) {
      return Error{
          ErrorKind::usage,
          fmt::format("sequence {} has {}, sequence {} has {}: --stack cannot put them into one "
                      "array; add --pad, which pads to the largest, or omit --stack to give "
                      "each sequence its own arrays",
                      first->row.sequence, in_words(extents_of(*first)), sequence.row.sequence,
                      in_words(extents))};
    }
    if (!first) first = sequence;
    plan.extents = larger(plan.extents, extents);
    plan.rows += sequence.row.pings();
    return {};
  });
  if (!read) return read.error();
  return plan;
}

Status write_stacked(const ExportJob& job, Hdf5File& file) {
  const auto plan = plan_stack(job);
  if (!plan) return plan.error();
  Stack stack(file, "", plan->rows, plan->extents, false);
  std::uint64_t row = 0;
  bool made = false;
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    if (!std::exchange(made, true)) stack.make(sequence);
    if (const Status written = write_sequence_group(job, file, sequence); !written) return written;
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return stack.write(job, sequence, ping, row++);
    });
  });
}

Status write_apart(const ExportJob& job, Hdf5File& file) {
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    file.release_arrays();
    if (const Status written = write_sequence_group(job, file, sequence); !written) return written;
    Stack stack(file, group_of(sequence.row), sequence.row.pings(), extents_of(sequence), true);
    stack.make(sequence);
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return stack.write(job, sequence, ping, ping.ping - sequence.row.first_ping);
    });
  });
}

}  // namespace

Status write_hdf5(const ExportJob& job, const std::filesystem::path& target) {
  const Result<const FileModule*> module = file_module();
  if (!module) return module.error();
  const std::unique_ptr<Hdf5File> opened((*module)->hdf5(target));
  Hdf5File& file = *opened;
  file.set_text("/", "name", job.dataset.name);
  file.set_text(
      "/", "axes",
      "timeseries [pings, beams, samples]; polar [pings, samples, beams]; cartesian "
      "[pings, rows, columns], boresight up, port left; beam 0 to starboard; front [pings, "
      "elevations, azimuths], lowest first");
  file.write_texts("/classes", job.dataset.classes);
  const Status written = job.options.stack ? write_stacked(job, file) : write_apart(job, file);
  const Status closed = file.close();
  return written ? closed : written;
}

}  // namespace ensonify
