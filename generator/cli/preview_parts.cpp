#include "cli/preview_parts.h"

#include <sys/stat.h>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "ping/session.h"

namespace ensonify {
namespace {

// Half of this number of rays would leave gaps between them.
constexpr int kFewRays = 16, kFewPerCell = 10;

OutputSelection pictures_alone(const OutputSelection& asked) {
  OutputSelection only;
  only.timeseries = only.cartesian = only.png = false;
  // Without images there are no labels, and no notes about them.
  const bool has_pictures = asked.pings && (asked.polar || asked.cartesian);
  only.shadow = asked.shadow || !has_pictures;
  only.amodal = asked.amodal || !has_pictures;
  only.multipath = asked.multipath;
  return only;
}

void thin_out(SonarSpec& sonar) {
  const int fewest = std::min(sonar.rays_elevation, kFewRays);
  sonar.rays_elevation = std::max((sonar.rays_elevation + 1) / 2, fewest);
  sonar.rays_azimuth = 1;
  if (auto& count = sonar.rays_per_cell)
    *count = std::max(*count / 2, std::min(*count, kFewPerCell));
}

std::string fan_text(const SonarSpec& sonar) {
  return fmt::format("{} x {}", sonar.beam_count * sonar.rays_azimuth, sonar.rays_elevation);
}

}  // namespace

std::vector<std::uint32_t> spread_pings(std::uint32_t pings, std::uint32_t count) {
  std::vector<std::uint32_t> chosen;
  count = std::min(count, pings);
  const std::uint64_t steps = count > 1 ? count - 1 : 1;
  for (std::uint64_t i = 0; i < count; ++i) {
    chosen.push_back(static_cast<std::uint32_t>((i * (pings - 1) + steps / 2) / steps));
  }
  return chosen;
}

Scenario reduced_scenario(const Scenario& scenario, bool full) {
  Scenario reduced = scenario;
  reduced.output.selection = pictures_alone(scenario.output.selection);
  reduced.output.sdf.reset();
  reduced.output.height_map.reset();
  reduced.navigation.reset();
  if (full) return reduced;
  thin_out(reduced.sonar);
  // A single ping looks the same with either speckle, and fixed scatterers need all rays.
  if (reduced.scattering.speckle == SpeckleMode::surface) {
    reduced.scattering.speckle = SpeckleMode::per_ping;
  }
  reduced.synthesis_tolerance =
      std::max(scenario.synthesis_tolerance, Scenario{}.synthesis_tolerance);
  return reduced;
}

std::string reduction_text(const Scenario& scenario, const Scenario& reduced) {
  const SonarSpec &all = scenario.sonar, &few = reduced.sonar;
  std::string text = "rays " + fan_text(few);
  if (fan_text(all) != fan_text(few)) text += " instead of " + fan_text(all);
  if (all.rays_per_cell != few.rays_per_cell) {
    text += fmt::format(", {} per cell instead of {}", *few.rays_per_cell, *all.rays_per_cell);
  }
  if (scenario.scattering.speckle != reduced.scattering.speckle) {
    text += ", speckle per_ping instead of surface";
  }
  if (scenario.synthesis_tolerance < reduced.synthesis_tolerance) {
    text += fmt::format(", tolerance {} instead of {}", reduced.synthesis_tolerance,
                        scenario.synthesis_tolerance);
  }
  return text + "; images and labels only";
}

namespace {

constexpr std::chrono::milliseconds kPause(250);
constexpr int kPausesBetweenQuestions = 4;

FileStamp stamp_of(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return {};
  return {true, static_cast<std::uint64_t>(status.st_size), status.st_ino, status.st_mtim.tv_sec,
          status.st_mtim.tv_nsec};
}

}  // namespace

void FileWatch::watch(const std::vector<std::filesystem::path>& files) {
  std::map<std::filesystem::path, FileStamp> stamps;
  for (const std::filesystem::path& file : files) {
    const auto known = stamps_.find(file);
    stamps[file] = known != stamps_.end() ? known->second : stamp_of(file);
  }
  stamps_ = std::move(stamps);
}

void FileWatch::renew() {
  for (auto& [file, stamp] : stamps_) stamp = stamp_of(file);
}

bool FileWatch::changed() const {
  for (const auto& [file, stamp] : stamps_) {
    if (stamp_of(file) != stamp) return true;
  }
  return false;
}

void wait_for_change(FileWatch& files, const std::function<bool()>& also, bool (*stop)()) {
  for (int pauses = 1; !stop(); ++pauses) {
    std::this_thread::sleep_for(kPause);
    const bool asks = also && pauses % kPausesBetweenQuestions == 0;
    if (files.changed() || (asks && also())) break;
  }
  for (FileWatch before; !stop() && before != files;) {
    before = files;
    std::this_thread::sleep_for(kPause / 2);
    files.renew();
  }
}

}  // namespace ensonify
