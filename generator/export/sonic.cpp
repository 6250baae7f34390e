// Pairs of pings for SONIC (Gode, Hinduja and Kaess, "SONIC: Sonar image correspondence using pose
// supervised learning for imaging sonars", 2024): images/SEQUENCE/PPPPPP.npy, float32 amplitudes
// [samples x beams] from 0 to 1, poses/SEQUENCE/PPPPPP.npy, float64 [4 x 4], sonar to world, and
// logs/pairs.txt, logs/pairs_pos.txt of the split train. Those of val and test end with _val and
// _test. The reader turns an image by 180 degrees, so that it is stored nearest sample first and
// starboard first.
//
// A pair is two pings of a sequence of which each sees the middle of the other's fan: the point on
// the boresight at half the sum of the range limits.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <map>
#include <memory>

#include "core/sonar.h"
#include "export/ping_values.h"
#include "formats/files.h"
#include "formats/npy.h"
#include "formats/output_place.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

struct PosedPing {
  std::uint32_t ping = 0;
  Pose sonar_in_world;
};

bool sees(const Sonar& sonar, const Pose& pose, const Vec3& point) {
  const Vec3 p = inverse_transform_point(pose, point);
  const double range_m = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
  return range_m >= sonar.range_min_m && range_m <= sonar.range_max_m &&
         std::abs(std::atan2(p.y, p.x)) <= 0.5 * sonar.beam_count * sonar.beam_spacing_rad &&
         std::abs(std::asin(p.z / range_m)) <= 0.5 * sonar.elevation_fan_rad;
}

class PairLists {
 public:
  explicit PairLists(const fs::path& target) : target_(target) {}

  Status add(const StoredSequence& sequence, const std::vector<PosedPing>& pings,
             const std::function<bool()>& stop) {
    const Sonar& sonar = sequence.manifest.info.sonar;
    const Vec3 middle{0.5 * (sonar.range_min_m + sonar.range_max_m), 0, 0};
    auto& [images, poses] = lists_of(sequence.row.split);
    const auto line = [&](const char* folder, const PosedPing& a, const PosedPing& b) {
      return fmt::format("{0}/{1:06}/{2:06}.npy {0}/{1:06}/{3:06}.npy\n", folder,
                         sequence.row.sequence, a.ping, b.ping);
    };
    for (std::size_t i = 0; i < pings.size(); ++i) {
      if (stop && stop()) {
        return Error{ErrorKind::interrupted, "interrupted; no files were left"};
      }
      const Pose& a = pings[i].sonar_in_world;
      for (std::size_t k = i + 1; k < pings.size(); ++k) {
        const Pose& b = pings[k].sonar_in_world;
        if (!sees(sonar, a, transform_point(b, middle)) ||
            !sees(sonar, b, transform_point(a, middle)))
          continue;
        images->append(line("images", pings[i], pings[k]));
        poses->append(line("poses", pings[i], pings[k]));
      }
    }
    return {};
  }
  Status close() {
    for (auto& [split, files] : lists_) {
      for (auto* file : {&files.first, &files.second}) {
        if (const Status closed = (*file)->close(); !closed) return closed;
      }
    }
    return {};
  }

 private:
  using Files = std::pair<std::unique_ptr<StreamedFile>, std::unique_ptr<StreamedFile>>;
  Files& lists_of(const std::string& split) {
    const auto [found, is_new] = lists_.try_emplace(split);
    if (is_new) {
      const std::string end = (split == "train" ? "" : "_" + split) + ".txt";
      found->second = {std::make_unique<StreamedFile>(target_ / "logs" / ("pairs" + end)),
                       std::make_unique<StreamedFile>(target_ / "logs" / ("pairs_pos" + end))};
    }
    return found->second;
  }

  fs::path target_;
  std::map<std::string, Files> lists_;
};

Status write_posed_ping(const ExportJob& job, const fs::path& target,
                        const StoredSequence& sequence, const StoredPing& ping,
                        const DatasetScale& scale) {
  const auto amplitudes = scaled_amplitudes(job, sequence, ping.ping, scale);
  if (!amplitudes) return amplitudes.error();
  const fs::path name = fmt::format("{:06}/{:06}.npy", sequence.row.sequence, ping.ping);
  const Status written = write_whole(target / "images" / name,
                                     encode_npy(*amplitudes, {sequence.samples, sequence.beams}));
  if (!written) return written;
  return write_whole(target / "poses" / name, encode_npy(matrix_of(ping.sonar_in_world), {4, 4}));
}

}  // namespace

Status write_sonic(const ExportJob& job, const fs::path& target) {
  const auto scale = scale_of_dataset(job);
  if (!scale) return scale.error();
  PairLists lists(target);
  const Status written = for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    if (const Status fits = equal_beams(sequence); !fits) return fits;
    std::vector<PosedPing> pings;
    const Status read = for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      pings.push_back({ping.ping, ping.sonar_in_world});
      return write_posed_ping(job, target, sequence, ping, *scale);
    });
    return read ? lists.add(sequence, pings, job.options.stop) : read;
  });
  return written ? lists.close() : written;
}

}  // namespace ensonify
