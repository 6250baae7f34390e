// The numerics that determine the last bits of a result on this machine, and tables that depend
// only on sonar, water and record. Computing the tables takes as long as some pings of a small run,
// so runs with equal tables share them.
//
//   BackendChoice  Numerics  settle_backend  make_backend  numerics_name
//   HiddenPower  hidden_power        the scale for comparing hidden echoes with the noise
//   PowerSpread  power_spread        how beams and pulse spread the power of echoes
//   PipelineTables  pipeline_tables
//   table_key  TableCache            tables in use, and the last ones
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/recent_entries.h"
#include "core/runtime.h"
#include "core/sonar.h"
#include "instrument/beam_noise.h"
#include "instrument/detector.h"
#include "labels/cartesian_display.h"
#include "ping/session.h"
#include "synthesis/backend.h"
#include "trace/tracer.h"

namespace ensonify {

enum class BackendChoice { automatic, cpu, cuda, reference };

class TableCache;

struct Numerics {
  BackendChoice backend = BackendChoice::cpu;
  SimdLevel simd = best_simd_level();
  std::string backend_name = "cpu";         // as in work.json; for cuda with the name of the device
  bool may_fall_back = false;               // to cpu, since `automatic` chose the device
  std::string no_device = {};               // why `automatic` chose cpu where there is a driver
  std::shared_ptr<TableCache> tables = {};  // of several runs or sequences
};

// `automatic` becomes cuda if a device is available, otherwise cpu. Error (device): cuda is
// requested, but there is no device. Whether the device can make the pings of a scenario is for
// numerics_that_fit (run/memory_room.h).
Result<Numerics> settle_backend(BackendChoice choice, SimdLevel simd);

// `numerics` must be settled. Throws DeviceFailure if the device is no longer available.
std::unique_ptr<Backend> make_backend(const Numerics& numerics, const SynthesisSetup& setup);

// The level of the program's own loops and, if it differs, the best level of the processor, by
// which FFTW and the mathematical library choose their code ("avx512", "sse4 on avx512").
std::string numerics_name(SimdLevel used);

// power_per_energy and pulse_power of labels/shadow.h.
struct HiddenPower {
  std::vector<double> per_energy, pulse;
};

// The expected power of a pixel whose neighbors in azimuth have as much energy in an angle as it
// has: S0^2 sum_i B(i - j)^2 w_i / (w_j N_j^2) in beam j, w the widths of cells, for an array S0^2
// sum_i |sum_n weight_n response_n E(u_i) e^(i 2 pi f_c y_n (sin theta_i - sin theta_j) / c)|^2;
// and |s(t)|^2.
HiddenPower hidden_power(const Sonar& sonar, const Water& water, const Record& record);

// The expected power of diffuse echoes with powers P_c (core/scatterers.h) in beam cells i_c with
// delays tau_c, in samples, is
//   sum_i beam[j][i] (A_0 + 2 Re sum_{k>=1} A_k e^(i 2 pi k n / M)),
//   A_k = pulse_k sum_{c: i_c = i} P_c e^(-i 2 pi k tau_c / M)
// in beam j and sample n (backend.h), for beams without an array.
struct PowerSpread {
  std::vector<float> beam;                 // [beams x cells], (B_j(theta_i) / N_j)^2
  std::vector<std::complex<float>> pulse;  // [M], pulse_autospectrum; M is record.transform
};
PowerSpread power_spread(const Sonar& sonar, const Record& record);

struct PipelineTables {
  Fan fan;
  std::unique_ptr<Backend> backend;  // may be used by several threads at once
  std::vector<std::int32_t> cartesian_map;
  std::optional<Footprints> footprints;  // unless 8-bit images are nearest neighbor
  HiddenPower hidden_power;
  std::optional<BeamNoise> beam_noise;  // with noise.correlated
  std::optional<SubBands> sub_bands;    // of a detector with several looks
  std::vector<Vec3> camera_rays;        // of a camera (camera/view.h); empty: none
};

// Whether there are 8-bit Cartesian images that are not nearest neighbor.
bool needs_footprints(const OutputSpec& output);

// Takes the tables from `numerics.tables` if it has them, and computes them otherwise. Throws
// DeviceFailure.
std::shared_ptr<const PipelineTables> pipeline_tables(const Session& session,
                                                      const Numerics& numerics);

// If keys are equal, tables are equal on one machine as long as input files do not change. The key
// is the whole scenario without keys that are known not to matter, so that a forgotten key
// separates tables instead of mixing them.
std::string table_key(const Scenario& scenario);

class TableCache {
 public:
  explicit TableCache(std::size_t kept = 2) : entries_(kept) {}

  // May be called from several threads at once; the first caller makes the tables.
  template <class Make>
  std::shared_ptr<const PipelineTables> of(const std::string& key, Make make) {
    const std::shared_ptr<Entry> entry = entries_.at(key);
    const std::lock_guard lock(entry->mutex);
    if (!entry->tables) entry->tables = make();
    // A holder of the tables also holds their entry.
    return {entry, entry->tables.get()};
  }

 private:
  struct Entry {
    std::mutex mutex;
    std::shared_ptr<const PipelineTables> tables;
  };
  RecentEntries<std::string, Entry> entries_;
};

}  // namespace ensonify
