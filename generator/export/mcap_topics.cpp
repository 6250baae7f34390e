#include "export/mcap_topics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/units.h"
#include "dataset/echo_arrays.h"
#include "dataset/layout.h"
#include "dataset/mask.h"
#include "export/ping_values.h"
#include "export/ros_navigation.h"
#include "export/sonar_numbers.h"
#include "formats/bytes.h"
#include "formats/npy.h"

namespace ensonify {
namespace {

constexpr char kWorldFrame[] = "world", kSonarFrame[] = "sonar", kFanFrame[] = "sonar_fan";

// SonarInfo is written again after this time, since recordings are cut into pieces.
constexpr std::uint64_t kInfoPeriodNs = 5'000'000'000;

// rosbag2 reads the quality of service from here: without one it takes its own.
constexpr char kLatched[] =
    "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n"
    "  deadline:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  liveliness: 1\n"
    "  liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  avoid_ros_namespace_conventions: false";

Result<std::vector<double>> axis_of(const ExportJob& job, const StoredSequence& sequence,
                                    const char* name, std::uint64_t count) {
  const auto path = stored_file(job.dataset, sequence.row.sequence, name);
  if (!path) return path.error();
  const auto array = read_npy(*path, kNpyFloat64, {count});
  if (!array) return array.error();
  return values_in<double>(array->data());
}

template <class Value>
std::string bytes_of(const std::vector<Value>& values) {
  return std::string(static_cast<const char*>(static_cast<const void*>(values.data())),
                     values.size() * sizeof(Value));
}

RosImage ros_image(std::uint64_t rows, std::uint64_t columns, const char* encoding,
                   std::string data) {
  RosImage image;
  image.height = static_cast<std::uint32_t>(rows);
  image.width = static_cast<std::uint32_t>(columns);
  image.encoding = encoding;
  image.step = static_cast<std::uint32_t>(data.size() / rows);
  image.data = std::move(data);
  return image;
}

// x' = z, y' = -y, z' = x: half a turn about the axis between x and z.
Pose fan_in_sonar() {
  constexpr double kHalf = std::numbers::sqrt2 / 2;
  return {{}, {0, kHalf, 0, kHalf}};
}

Pose pose_in(const Pose& frame, const Pose& pose) {
  return {inverse_transform_point(frame, pose.position_m),
          conjugate(frame.rotation) * pose.rotation};
}

// 0 of no instance.
std::uint8_t class_of(const StoredSequence& sequence, std::uint16_t instance) {
  return instance == 0 ? std::uint8_t{0} : sequence.instances[instance - 1U].class_id;
}

SonarInfo::Tvg tvg_of(const Display& display) {
  if (same_tvg(display, Display{})) return SonarInfo::kNoTvg;
  if (display.spreading == 20) return SonarInfo::k20LogR;
  if (display.spreading == 40) return SonarInfo::k40LogR;
  return SonarInfo::kCustomTvg;
}

// What the 8-bit values mean.
void describe_grey(const Display& display, double absorption_db_m, SonarInfo& info) {
  // An unknown gain of the instrument stays one.
  const bool is_known = info.tvg != SonarInfo::kTvgUnknown;
  if (is_known) info.tvg = tvg_of(display);
  if (is_known && info.tvg != SonarInfo::kNoTvg) {
    info.tvg_absorption_db_km = static_cast<float>(display.absorption ? 1e3 * absorption_db_m : 0);
  }
  const bool fixed = display.scale == GreyScale::db && !display.automatic_gain;
  if (!fixed || info.tvg != SonarInfo::kNoTvg) info.reference = SonarInfo::kRelative;
  if (!fixed) {
    info.raw_scale = 0;
    info.scale = display.scale == GreyScale::db ? SonarInfo::kDb : SonarInfo::kScaleUnknown;
    return;
  }
  const auto [black, white] = display.limits_db;
  info.raw_scale = static_cast<float>((white - black) / 255);
  info.raw_offset = static_cast<float>(black - display.gain_db);
}

}  // namespace

void McapChannels::write_bytes(const std::string& topic, const std::string& type,
                               std::uint64_t time_ns, const std::string& bytes, bool latched) {
  auto channel = channels_.find(topic);
  if (channel == channels_.end()) {
    auto schema = schemas_.find(type);
    if (schema == schemas_.end()) {
      const std::uint16_t number = file_.add_schema(type, "ros2msg", ros_definition(type));
      schema = schemas_.emplace(type, number).first;
    }
    const std::map<std::string, std::string> metadata = {
        {"offered_qos_profiles", latched ? kLatched : ""}};
    channel =
        channels_.emplace(topic, Channel{file_.add_channel(schema->second, topic, "cdr", metadata)})
            .first;
  }
  file_.write(channel->second.number, channel->second.messages++, time_ns, bytes);
}

bool SonarTopics::has_grey(ImageView view) const {
  if (!job_.render) return sequence_.has(grey_row(view));
  const auto& views = job_.render->views;
  return std::find(views.begin(), views.end(), view_name(view)) != views.end();
}

Status SonarTopics::start() {
  if (!is_sonar(sequence_.manifest.info)) return {};
  if (!has_grey(ImageView::polar) &&
      !stored_planes(sequence_, ImageView::polar).count("level_db")) {
    return need(job_, sequence_, grey_row(ImageView::polar));
  }
  const auto ranges = axis_of(job_, sequence_, "range_m.npy", sequence_.samples);
  if (!ranges) return ranges.error();
  auto azimuths = axis_of(job_, sequence_, "azimuth_rad.npy", sequence_.beams);
  if (!azimuths) return azimuths.error();
  make_image(*azimuths, *ranges);
  make_infos();
  azimuths_rad_ = std::move(*azimuths);
  return {};
}

void SonarTopics::make_image(const std::vector<double>& azimuths,
                             const std::vector<double>& ranges) {
  image_.header.frame_id = kFanFrame;
  image_.frequency_hz = static_cast<float>(sequence_.frequency_hz);
  image_.sound_speed_m_s = static_cast<float>(sequence_.sound_speed_m_s);
  image_.rx_beamwidths_rad.assign(sequence_.beams, static_cast<float>(sequence_.beam_width_rad));
  const std::vector<double>& widths = sequence_.manifest.info.sonar.width_rad;
  for (std::size_t j = 0; j < widths.size(); ++j) {
    image_.rx_beamwidths_rad[j] = static_cast<float>(widths[j]);
  }
  image_.tx_beamwidths_rad.assign(sequence_.beams,
                                  static_cast<float>(sequence_.elevation_width_rad));
  for (const double azimuth : azimuths) {
    image_.beam_directions.push_back({0, -std::sin(azimuth), std::cos(azimuth)});
  }
  image_.ranges_m.assign(ranges.begin(), ranges.end());
  image_.beam_count = static_cast<std::uint32_t>(sequence_.beams);
}

void SonarTopics::make_infos() {
  const SequenceInfo& info = sequence_.manifest.info;
  SonarInfo& levels = levels_info_;
  levels.header.frame_id = kFanFrame;
  levels.sonar_model = info.recording ? info.recording->instrument : "simulated";
  levels.quantity = SonarInfo::kAmplitude;
  levels.scale = SonarInfo::kDb;
  levels.reference = info.recording ? SonarInfo::kRelative : SonarInfo::kAbsolute;
  levels.raw_scale = 1;
  if (!info.recording) {
    const Pulse& pulse = info.sonar.pulse;
    const bool lasts = pulse.shape == PulseShape::lfm || pulse.shape == PulseShape::cw;
    levels.pulse_lengths_s = {
        static_cast<float>(lasts ? pulse.duration_s : effective_pulse_s(info))};
    levels.bandwidths_hz = {static_cast<float>(info.sonar.bandwidth_hz)};
    levels.signal_types = {pulse.shape == PulseShape::lfm     ? SonarInfo::kFmUp
                           : pulse.shape == PulseShape::table ? SonarInfo::kSignalUnknown
                                                              : SonarInfo::kCw};
    levels.tvg = SonarInfo::kNoTvg;
    levels.source_level_db = static_cast<float>(info.sonar.source_level_db);
    levels.angular_normalization = SonarInfo::kNotNormalized;
  }
  grey_info_ = levels;
  describe_grey(job_.render ? job_.render->display : info.png, info.water.absorption_db_m,
                grey_info_);
}

Status SonarTopics::write(const StoredPing& ping, std::uint64_t time_ns, McapChannels& channels) {
  write_frames(ping, time_ns, channels);
  if (!is_sonar(sequence_.manifest.info)) {
    told_ns_ = time_ns;
    return {};
  }
  if (!told_ns_ || time_ns - *told_ns_ >= kInfoPeriodNs) {
    told_ns_ = levels_info_.header.time_ns = grey_info_.header.time_ns = time_ns;
    if (has_grey(ImageView::polar)) channels.write("/sonar/image/info", time_ns, grey_info_, true);
    if (stored_planes(sequence_, ImageView::polar).count("level_db")) {
      channels.write("/sonar/levels/info", time_ns, levels_info_, true);
    }
  }
  if (const Status polar = write_polar(ping, time_ns, channels); !polar) return polar;
  return write_cartesian(ping, time_ns, channels);
}

void SonarTopics::write_frames(const StoredPing& ping, std::uint64_t time_ns,
                               McapChannels& channels) {
  const auto& navigation = sequence_.manifest.info.navigation;
  const bool hears = is_sonar(sequence_.manifest.info);
  if (!told_ns_) {
    TfMessage fixed;
    if (hears) fixed.transforms = {{{time_ns, kSonarFrame}, kFanFrame, fan_in_sonar()}};
    if (navigation) {
      const auto frames = sensor_frames(*navigation, {time_ns, kBodyFrame}, kSonarFrame);
      fixed.transforms.insert(fixed.transforms.end(), frames.begin() + (hears ? 0 : 1),
                              frames.end());
    }
    channels.write("/tf_static", time_ns, fixed, true);
  }
  const RosHeader world{time_ns, kWorldFrame};
  if (hears) channels.write("/sonar/pose", time_ns, PoseStamped{world, ping.sonar_in_world});
  TfMessage moving{{{world, kSonarFrame, ping.sonar_in_world}}};
  if (navigation) {
    moving.transforms[0] = {world, kBodyFrame, body_in_world(*navigation, ping.sonar_in_world)};
  }
  for (const StoredObjectPose& object : ping.objects) {
    const StoredInstance& instance = sequence_.instances[object.instance - 1];
    const std::string frame =
        fmt::format("object_{}_{}", instance.id, plain_name(instance.name, 64));
    moving.transforms.push_back({world, frame, object.in_world});
  }
  channels.write("/tf", time_ns, moving);
}

Status SonarTopics::write_polar(const StoredPing& ping, std::uint64_t time_ns,
                                McapChannels& channels) {
  image_.header.time_ns = time_ns;
  if (has_grey(ImageView::polar)) {
    const auto grey = path_of(job_, sequence_, ping, grey_row(ImageView::polar));
    if (!grey) return grey.error();
    const auto pixels = grey_pixels(job_, *grey, sequence_.samples, sequence_.beams);
    if (!pixels) return pixels.error();
    image_.type = ProjectedSonarImage::kUint8;
    image_.data = bytes_of(*pixels);
    channels.write("/sonar/image", time_ns, image_);
  }
  const auto polar = read_picture(
      job_.dataset, sequence_, ImageView::polar, ping.ping,
      {"level_db", "instance", "semantic", "surface_range_m", "surface_elevation_rad"});
  if (!polar) return polar.error();
  if (!polar->level_db.empty()) {
    image_.type = ProjectedSonarImage::kFloat32;
    image_.data = bytes_of(polar->level_db);
    channels.write("/sonar/levels", time_ns, image_);
  }
  write_masks(*polar, "/sonar/polar", time_ns, channels);
  const Status detected =
      write_detections(ping, ImageView::polar, "/sonar/polar", time_ns, channels);
  return detected ? write_points(ping, *polar, time_ns, channels) : detected;
}

Status SonarTopics::write_cartesian(const StoredPing& ping, std::uint64_t time_ns,
                                    McapChannels& channels) {
  const std::uint64_t rows = sequence_.cartesian_height, columns = sequence_.cartesian_width;
  if (has_grey(ImageView::cartesian)) {
    const auto grey = path_of(job_, sequence_, ping, grey_row(ImageView::cartesian));
    if (!grey) return grey.error();
    const auto pixels = grey_pixels(job_, *grey, rows, columns);
    if (!pixels) return pixels.error();
    RosImage image = ros_image(rows, columns, "mono8", bytes_of(*pixels));
    image.header = {time_ns, kSonarFrame};
    channels.write("/sonar/cartesian/image", time_ns, image);
  }
  if (rows == 0) return {};
  const auto pixels = read_picture(job_.dataset, sequence_, ImageView::cartesian, ping.ping,
                                   {"instance", "semantic"});
  if (!pixels) return pixels.error();
  write_masks(*pixels, "/sonar/cartesian", time_ns, channels);
  return write_detections(ping, ImageView::cartesian, "/sonar/cartesian", time_ns, channels);
}

void SonarTopics::write_masks(const StoredPixels& pixels, const std::string& prefix,
                              std::uint64_t time_ns, McapChannels& channels) const {
  const auto write = [&](const char* name, const char* encoding, const auto& values) {
    if (values.empty()) return;
    RosImage image = ros_image(pixels.rows, pixels.columns, encoding, bytes_of(values));
    image.header = {time_ns, kSonarFrame};
    channels.write(prefix + name, time_ns, image);
  };
  write("/instance", "16UC1", pixels.instance);
  write("/semantic", "8UC1", pixels.semantic);
}

Status SonarTopics::write_detections(const StoredPing& ping, ImageView view,
                                     const std::string& prefix, std::uint64_t time_ns,
                                     McapChannels& channels) const {
  if (!sequence_.has(plane_row(view, "instance"))) return {};
  const auto picture = picture_of_view(job_, sequence_, ping, view);
  if (!picture) return picture.error();
  Detections message{{time_ns, kSonarFrame}, {}};
  for (const StoredAnnotation& annotation : picture->annotations) {
    const StoredInstance& instance = sequence_.instances[annotation.instance - 1U];
    const Mask mask = mask_of(annotation.runs, static_cast<std::int64_t>(picture->height));
    Detections::Detection detection{
        instance.class_name,
        std::to_string(instance.id),
        {1. * mask.left, 1. * mask.top, 1. * mask.width, 1. * mask.height},
        {}};
    for (const StoredObjectPose& object : ping.objects) {
      if (object.instance != annotation.instance) continue;
      detection.pose = pose_in(ping.sonar_in_world, object.in_world);
    }
    message.detections.push_back(std::move(detection));
  }
  channels.write(prefix + "/detections", time_ns, message);
  return {};
}

Status SonarTopics::write_points(const StoredPing& ping, const StoredPixels& polar,
                                 std::uint64_t time_ns, McapChannels& channels) const {
  PointCloud2 cloud;
  cloud.header = {time_ns, kSonarFrame};
  if (!polar.surface_range_m.empty() && !polar.level_db.empty()) {
    add_surfaces(polar, cloud);
  } else if (sequence_.has(*find_file(FileScope::ping, layout::kScatterers))) {
    if (const Status added = add_scatterers(ping, cloud); !added) return added;
  } else {
    return {};
  }
  channels.write("/sonar/points", time_ns, cloud);
  return {};
}

// The point of each pixel that has an instance with a surface.
void SonarTopics::add_surfaces(const StoredPixels& polar, PointCloud2& cloud) const {
  for (std::size_t i = 0; i < polar.surface_range_m.size(); ++i) {
    const double range = polar.surface_range_m[i], elevation = polar.surface_elevation_rad[i];
    if (!std::isfinite(range)) continue;
    const double azimuth = azimuths_rad_[i % sequence_.beams], level = range * std::cos(elevation);
    const Vec3 place{level * std::cos(azimuth), level * std::sin(azimuth),
                     range * std::sin(elevation)};
    cloud.add(place, polar.level_db[i], polar.instance[i], polar.semantic[i]);
  }
}

// Every scatterer, with the level of its echo in its own beam.
Status SonarTopics::add_scatterers(const StoredPing& ping, PointCloud2& cloud) const {
  const auto path =
      path_of(job_, sequence_, ping, *find_file(FileScope::ping, layout::kScatterers));
  if (!path) return path.error();
  const auto array = read_npy(*path, kNpyScatterer, {0});
  if (!array) return array.error();
  std::string_view rest = array->data();
  for (; !rest.empty(); rest.remove_prefix(kScattererBytes)) {
    const auto [place, intensity, instance] = scatterer_at(rest);
    if (instance > sequence_.instances.size()) {
      return damaged(*path, fmt::format("refers to an unknown instance {}", instance));
    }
    const double level_db =
        intensity > 0 ? 10 * std::log10(intensity) + sequence_.manifest.info.sonar.source_level_db
                      : kNoEnergyDb;
    const auto id = static_cast<std::uint16_t>(instance);
    cloud.add(inverse_transform_point(ping.sonar_in_world, place), static_cast<float>(level_db), id,
              class_of(sequence_, id));
  }
  return {};
}

}  // namespace ensonify
