// The class Ping of the extension, whose arrays are views of what the pipeline made.
#include <pybind11/complex.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "core/camera_planes.h"
#include "core/front_planes.h"
#include "core/image_planes.h"
#include "dataset/texts.h"
#include "ping/sequence_info.h"
#include "ping/tables.h"
#include "python/values.h"
#include "run/ping_stream.h"

namespace ensonify::python {
namespace py = pybind11;
namespace {

// A view of the values, which `owner` keeps alive.
template <class Values>
py::array_t<typename Values::value_type> view_of(const Values& values,
                                                 std::vector<py::ssize_t> shape, py::handle owner) {
  return py::array_t<typename Values::value_type>(std::move(shape), values.data(), owner);
}

// None if the image has no such plane.
template <class Image, class Planes>
py::object plane_of(const Image& image, const Planes& planes, const std::string& name,
                    py::handle owner) {
  for (const auto& plane : planes) {
    if (name != plane.name) continue;
    return with_plane(image, plane, [&](const auto& values) -> py::object {
      if (values.empty()) return py::none();
      std::vector<py::ssize_t> shape = {image.rows, image.columns};
      if constexpr (requires { plane.channels; }) {
        if (plane.channels > 1) shape.push_back(plane.channels);
      }
      return view_of(values, std::move(shape), owner);
    });
  }
  return py::none();
}

// None if the ping has no such array.
py::object array_of(py::object self, const std::string& view, const std::string& name) {
  const auto& result = self.cast<const StreamedPing&>().result;
  if (view == "front") {
    return result.front ? plane_of(*result.front, kFrontPlanes, name, self)
                        : py::object(py::none());
  }
  if (view == "camera") {
    return result.camera ? plane_of(*result.camera, kCameraPlanes, name, self)
                         : py::object(py::none());
  }
  const bool polar = view == "polar";
  if (name == "grey") {
    const auto& grey = polar ? result.polar_grey : result.cartesian_grey;
    if (!grey) return py::none();
    return view_of(grey->pixels, {grey->rows, grey->columns}, self);
  }
  const auto& image = polar ? result.polar : result.cartesian;
  return image ? plane_of(*image, kImagePlanes, name, self) : py::object(py::none());
}

const SequenceInfo& info_of(const StreamedPing& ping) { return *ping.info; }

py::object series_of(const StreamedPing& ping, const Series& series, std::size_t rows,
                     py::handle owner) {
  if (series.empty()) return py::none();
  return view_of(series, {static_cast<py::ssize_t>(rows), info_of(ping).record.samples}, owner);
}

py::object layer_of(py::object self, const std::string& name) {
  const auto& ping = self.cast<const StreamedPing&>();
  for (const LayerSeries& layer : ping.result.layers) {
    if (name == layer_name(layer.layer)) {
      return series_of(ping, layer.pressure_pa, info_of(ping).sonar.beam_count, self);
    }
  }
  return py::none();
}

// None without a recorder.
py::object recorded_of(py::object self) {
  const auto& ping = self.cast<const StreamedPing&>();
  const RecordedPing& recorded = ping.result.recorded;
  const std::vector<py::ssize_t> shape = {info_of(ping).record.samples,
                                          info_of(ping).sonar.beam_count};
  if (!recorded.counts_8.empty()) return view_of(recorded.counts_8, shape, self);
  if (!recorded.counts_16.empty()) return view_of(recorded.counts_16, shape, self);
  return py::none();
}

// None without row gains.
py::object row_gain_of(py::object self) {
  const auto& gain = self.cast<const StreamedPing&>().result.recorded.row_gain;
  if (gain.empty()) return py::none();
  return view_of(gain, {static_cast<py::ssize_t>(gain.size())}, self);
}

// None: not asked for.
py::object elevation_of(py::object self) {
  const auto& ping = self.cast<const StreamedPing&>();
  if (!info_of(ping).output.elevation) return py::none();
  const auto& echoes = ping.result.elevation;
  return py::array_t<ElevationEcho>(static_cast<py::ssize_t>(echoes.size()), echoes.data(), self);
}

// As the arrays beam_power.npy and pulse_power.npy; None with an array of elements.
py::object power_spread_of(const StreamedPing& ping) {
  const SequenceInfo& info = info_of(ping);
  if (info.sonar.array || !info.output.elevation) return py::none();
  const PowerSpread spread = power_spread(info.sonar, info.record);
  const auto beams = static_cast<py::ssize_t>(info.sonar.beam_count);
  return py::make_tuple(py::array_t<float>({beams, beams}, spread.beam.data()),
                        py::array_t<std::complex<float>>(
                            static_cast<py::ssize_t>(spread.pulse.size()), spread.pulse.data()));
}

// As x, y, z, w, qx, qy, qz.
std::array<double, 7> pose_of(const Pose& pose) {
  const auto& [p, q] = pose;
  return {p.x, p.y, p.z, q.w, q.x, q.y, q.z};
}

std::vector<std::array<double, 7>> object_poses_of(const StreamedPing& ping) {
  std::vector<std::array<double, 7>> poses;
  for (const Pose& pose : ping.result.object_in_world) poses.push_back(pose_of(pose));
  return poses;
}

py::array_t<double> ranges_of(const StreamedPing& ping) {
  const SequenceInfo& info = info_of(ping);
  std::vector<double> ranges_m;
  for (int n = 0; n < info.record.samples; ++n) {
    ranges_m.push_back(sample_range_m(info.sonar, info.water, n));
  }
  return py::array_t<double>(static_cast<py::ssize_t>(ranges_m.size()), ranges_m.data());
}

// The directions of beams or of rays.
template <std::vector<double> angles_rad(const Sonar&)>
py::array_t<double> angles_of(const StreamedPing& ping) {
  const std::vector<double> values = angles_rad(info_of(ping).sonar);
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

py::object map_of(py::object self) {
  const auto& ping = self.cast<const StreamedPing&>();
  const auto& grid = info_of(ping).cartesian;
  if (!grid) return py::none();
  return view_of(ping.tables->cartesian_map, {grid->height_px, grid->width_px}, self);
}

}  // namespace

void bind_ping(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(ElevationEcho, sample, beam, step, offset, diffuse_pa2, coherent_pa,
                       instance, path);
  py::class_<StreamedPing, std::shared_ptr<StreamedPing>>(module, "Ping")
      .def_property_readonly("sequence", [](const StreamedPing& p) { return info_of(p).sequence; })
      .def_property_readonly("number", [](const StreamedPing& p) { return p.result.ping; })
      .def_property_readonly("pings", [](const StreamedPing& p) { return p.pings; })
      .def_property_readonly("time_s", [](const StreamedPing& p) { return p.result.time_s; })
      .def_property_readonly("pose",
                             [](const StreamedPing& p) { return pose_of(p.result.sonar_in_world); })
      .def_property_readonly("object_poses", &object_poses_of)
      .def_property_readonly("info",
                             [](const StreamedPing& p) { return sequence_text(info_of(p)); })
      .def_property_readonly(
          "annotations",
          [](const StreamedPing& p) { return annotations_text(info_of(p), p.result); })
      .def_property_readonly("azimuth_rad", &angles_of<beam_azimuths_rad>)
      .def_property_readonly("front_azimuth_rad", &angles_of<ray_azimuths_rad>)
      .def_property_readonly("front_elevation_rad", &angles_of<ray_elevations_rad>)
      .def_property_readonly("range_m", &ranges_of)
      .def_property_readonly("cartesian_map", &map_of)
      .def_property_readonly(
          "first_return_m",
          [](py::object self) {
            const auto& values = self.cast<const StreamedPing&>().result.first_return_m;
            return view_of(values, {static_cast<py::ssize_t>(values.size())}, self);
          })
      .def_property_readonly("series",
                             [](py::object self) {
                               const auto& p = self.cast<const StreamedPing&>();
                               return series_of(p, p.result.series, info_of(p).sonar.beam_count,
                                                self);
                             })
      .def_property_readonly("channels",
                             [](py::object self) {
                               const auto& p = self.cast<const StreamedPing&>();
                               return series_of(p, p.result.channels, info_of(p).element_y_m.size(),
                                                self);
                             })
      .def_property_readonly("recorded", &recorded_of)
      .def_property_readonly("row_gain", &row_gain_of)
      .def_property_readonly("elevation", &elevation_of)
      .def_property_readonly("power_spread", &power_spread_of)
      .def("layer", &layer_of, py::arg("name"))
      .def("array", &array_of, py::arg("view"), py::arg("name"));
}

}  // namespace ensonify::python
