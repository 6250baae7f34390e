#include "export/mcap_navigation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/units.h"
#include "dataset/layout.h"
#include "export/ros_navigation.h"
#include "formats/csv.h"

namespace ensonify {
namespace {

double square(double value) { return value * value; }

// Half a turn about x: y to starboard, z down.
Vec3 down(const Vec3& v) { return {v.x, -v.y, -v.z}; }

Vec3 vector_at(const std::vector<double>& row, std::size_t i) {
  return {row[i], row[i + 1], row[i + 2]};
}

ImuMessage imu_message(const Imu& imu, const std::vector<double>& row, std::uint64_t time_ns) {
  // Random walks in SI units over the time of a sample.
  const double rate_hz = imu.clock.rate_hz;
  const double turning = imu.gyroscope ? imu.gyroscope->angle_random_walk_deg_sqrth : 0;
  const double force = imu.accelerometer ? imu.accelerometer->velocity_random_walk_m_s_sqrth : 0;
  return {{time_ns, "imu_link"},
          vector_at(row, 1),
          vector_at(row, 4),
          square(radians(turning) / 60) * rate_hz,
          square(force / 60) * rate_hz};
}

DvlMessage dvl_message(const Dvl& dvl, double sound_speed_m_s, const std::vector<double>& row,
                       std::uint64_t time_ns) {
  DvlMessage message;
  message.header = {time_ns, "dvl_link"};
  message.velocity_m_s = down(vector_at(row, 1));
  message.altitude_m = row[4];
  message.sound_speed_m_s = static_cast<float>(sound_speed_m_s);
  message.velocity_variance = square(dvl.velocity_noise_m_s);
  const std::array<Vec3, 4> beams = dvl_beams(dvl);
  std::array<bool, 4> locked{};
  for (std::size_t k = 0; k < beams.size(); ++k) {
    message.beams[k] = down(beams[k]);
    message.range_m[k] = row[5 + k];
    message.velocity_of_beam_m_s[k] = row[9 + k];
    message.range_variance[k] = square(dvl.range_noise_percent / 100 * row[5 + k]);
    locked[k] = !std::isnan(row[5 + k]);
    message.good_beams += locked[k] ? 1 : 0;
  }
  message.velocity_covariance.fill(-1);
  if (message.good_beams < 3) return message;
  const DvlNormal inverse = inverse_normal(message.beams, locked);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 line = message.velocity_variance * inverse[i];
    message.velocity_covariance[3 * i] = line.x;
    message.velocity_covariance[3 * i + 1] = line.y;
    message.velocity_covariance[3 * i + 2] = line.z;
  }
  return message;
}

RangeMessage range_message(const Altimeter& altimeter, const std::vector<double>& row,
                           std::uint64_t time_ns) {
  const double range_m = std::isnan(row[1]) ? std::numeric_limits<double>::infinity() : row[1];
  return {{time_ns, "altimeter_link"},
          static_cast<float>(altimeter.range_min_m),
          static_cast<float>(altimeter.range_max_m),
          static_cast<float>(range_m),
          static_cast<float>(square(altimeter.noise_m))};
}

PoseFix usbl_message(const Usbl& usbl, const std::vector<double>& row, std::uint64_t time_ns) {
  PoseFix message{{time_ns, "world"}, vector_at(row, 1), {}};
  const auto& [x, y, z] = usbl.transceiver_m;
  const Vec3 way_m = message.position_m - Vec3{x, y, z};
  const double across = square(radians(usbl.angle_noise_deg) * length(way_m));
  const double more = square(usbl.range_noise_m) - across;  // along the line of sight
  const double u[] = {way_m.x / length(way_m), way_m.y / length(way_m), way_m.z / length(way_m)};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      message.covariance[3 * i + j] = (i == j ? across : 0) + more * u[i] * u[j];
    }
  }
  return message;
}

OdometryMessage odometry_message(const std::vector<double>& row, std::uint64_t time_ns) {
  return {{time_ns, "odom"},
          kBodyFrame,
          {vector_at(row, 1), {row[4], row[5], row[6], row[7]}},
          vector_at(row, 8),
          vector_at(row, 11)};
}

}  // namespace

Status SensorTopics::start(const StoredDataset& dataset, const StoredSequence& sequence) {
  sequence_ = &sequence;
  const auto& navigation = sequence.manifest.info.navigation;
  if (!navigation) return {};
  for (std::size_t i = 0; i < std::size(kNavigationTables); ++i) {
    const auto kind = static_cast<NavigationTable>(i);
    if (kind == NavigationTable::imu_truth || !has_table(navigation->sensors, kind)) continue;
    const auto path = stored_file(dataset, sequence.row.sequence, kNavigationTables[i].name);
    if (!path) return path.error();
    Table table{kind, *path, std::ifstream(*path, std::ios::binary), {}, 0};
    const std::string_view header = kNavigationTables[i].header;
    std::string line;
    if (!std::getline(table.file, line) || line + "\n" != header) {
      return damaged(*path, "does not begin with the expected header");
    }
    table.row.resize(columns_of(header, ',').size());
    if (const Status read = advance(table); !read) return read;
    tables_.push_back(std::move(table));
  }
  return {};
}

std::optional<std::uint64_t> SensorTopics::first_ns() const {
  std::optional<std::uint64_t> first;
  for (const Table& table : tables_) {
    if (!table.row.empty()) first = std::min(first.value_or(table.time_ns), table.time_ns);
  }
  return first;
}

Status SensorTopics::advance(Table& table) {
  std::string line;
  if (!std::getline(table.file, line)) {
    table.row.clear();
    return {};
  }
  if (!read_numbers(line, table.row)) return damaged(table.path, "has an invalid row: " + line);
  const double time_ns = std::round(table.row[0] * 1e9);
  // Also refuses a time that is no number.
  if (!(time_ns >= static_cast<double>(table.time_ns) && time_ns < 2147483647e9)) {
    return damaged(table.path, "has a time that falls, or is not from 0 to 2147483647 s: " + line);
  }
  table.time_ns = static_cast<std::uint64_t>(time_ns);
  return {};
}

Result<std::uint64_t> SensorTopics::write_before(std::uint64_t own_ns, std::uint64_t shift_ns,
                                                 std::uint64_t last_ns, McapChannels& channels) {
  for (;;) {
    Table* next = nullptr;
    for (Table& table : tables_) {
      if (table.row.empty() || table.time_ns >= own_ns) continue;
      if (next == nullptr || table.time_ns < next->time_ns) next = &table;
    }
    if (next == nullptr) return last_ns;
    const std::uint64_t time_ns = next->time_ns + shift_ns;
    if (time_ns < last_ns) {
      return damaged(next->path, "begins before the first ping");
    }
    last_ns = time_ns;
    write(*next, time_ns, channels);
    if (const Status read = advance(*next); !read) return read.error();
  }
}

void SensorTopics::write(const Table& table, std::uint64_t time_ns, McapChannels& channels) {
  const SequenceInfo& info = sequence_->manifest.info;
  const Navigation& sensors = info.navigation->sensors;
  const std::vector<double>& row = table.row;
  switch (table.kind) {
    case NavigationTable::imu:
      return channels.write("/imu/data_raw", time_ns, imu_message(*sensors.imu, row, time_ns));
    case NavigationTable::imu_truth:
      return;
    case NavigationTable::dvl:
      return channels.write("/dvl/data", time_ns,
                            dvl_message(*sensors.dvl, info.water.sound_speed_m_s, row, time_ns));
    case NavigationTable::depth: {
      const double density = info.water.density_kg_m3;
      const double sigma_pa = density * kGravityMS2 * sensors.depth->noise_m;
      return channels.write("/depth/pressure", time_ns,
                            FluidPressure{{time_ns, "depth_link"}, row[2], square(sigma_pa)});
    }
    case NavigationTable::altimeter:
      return channels.write("/altimeter/range", time_ns,
                            range_message(*sensors.altimeter, row, time_ns));
    case NavigationTable::usbl:
      return channels.write("/usbl/fix", time_ns, usbl_message(*sensors.usbl, row, time_ns));
    case NavigationTable::gps:
      return channels.write("/gps/fix", time_ns,
                            NavSatFix{{time_ns, "gps_link"},
                                      row[1],
                                      row[2],
                                      row[3],
                                      square(sensors.gps->horizontal_noise_m),
                                      square(sensors.gps->vertical_noise_m)});
    case NavigationTable::odometry:
      return channels.write("/odometry", time_ns, odometry_message(row, time_ns));
  }
}

}  // namespace ensonify
