// What decides the last bits of a result on this machine, and what follows from the sonar, the
// water and the record alone. The latter takes as long to work out as some pings of a small run:
// runs that have it in common share it.
//
//   BackendChoice  Numerics  settle_backend  make_backend  numerics_name
//   HiddenPower  hidden_power        on what scale hidden echoes are weighed against the noise
//   PipelineTables  pipeline_tables
//   table_key  TableCache            tables that are in use, and the last ones
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/session.h"
#include "core/error.h"
#include "core/runtime.h"
#include "core/sonar.h"
#include "labels/cartesian_display.h"
#include "synthesis/backend.h"
#include "trace/tracer.h"

namespace ensonify {

enum class BackendChoice { automatic, cpu, cuda, reference };

class TableCache;

struct Numerics {
  BackendChoice backend = BackendChoice::cpu;
  SimdLevel simd = best_simd_level();
  std::string backend_name = "cpu";  // as work.json has it; with the device's name behind cuda
  std::shared_ptr<TableCache> tables = {};  // of several runs or sequences
};

// `automatic` becomes cuda where a device answers, else cpu. Error (device): cuda is asked for, and
// none answers.
Result<Numerics> settle_backend(BackendChoice choice, SimdLevel simd);

// `numerics` settled. Throws DeviceFailure where the device cannot be had any more.
std::unique_ptr<Backend> make_backend(const Numerics& numerics, const SynthesisSetup& setup);

// The level that the program's own loops use and, where it is another, what the processor offers:
// FFTW and the mathematical library choose their code by that ("avx512", "sse4 on avx512").
std::string numerics_name(SimdLevel used);

// labels/shadow.h's power_per_energy and pulse_power.
struct HiddenPower {
  std::vector<double> per_energy, pulse;
};

// The clean power of a pixel whose neighbours in azimuth hold as much energy as it does: S0^2
// sum_i B(i - j)^2 / N_j^2 in beam j, of an array S0^2 sum_i |sum_n weight_n response_n E(u_i)
// e^(i 2 pi f_c y_n (sin theta_i - sin theta_j) / c)|^2; and |s(t)|^2.
HiddenPower hidden_power(const Sonar& sonar, const Water& water, const Record& record);

struct PipelineTables {
  Fan fan;
  std::unique_ptr<Backend> backend;  // may be used by several threads at once
  std::vector<std::int32_t> cartesian_map;
  std::optional<Footprints> footprints;  // of 8-bit Cartesian images that are not nearest neighbor
  HiddenPower hidden_power;
};

// From `numerics.tables`, where it has any, if they are there. Throws DeviceFailure.
std::shared_ptr<const PipelineTables> pipeline_tables(const Session& session,
                                                      const Numerics& numerics);

// Equal keys: equal tables, on one machine and as long as input files do not change. The key is the
// whole scenario without what is known not to matter, so that what is forgotten keeps tables apart.
std::string table_key(const Scenario& scenario);

class TableCache {
 public:
  // May be called from several threads at once; whoever is first makes them.
  template <class Make>
  std::shared_ptr<const PipelineTables> of(const std::string& key, Make make) {
    const std::shared_ptr<Entry> entry = entry_of(key);
    const std::lock_guard lock(entry->mutex);
    if (!entry->tables) entry->tables = make();
    // Who holds the tables holds their entry.
    return {entry, entry->tables.get()};
  }

 private:
  struct Entry {
    std::mutex mutex;
    std::shared_ptr<const PipelineTables> tables;
  };
  static constexpr std::size_t kKept = 2;

  std::shared_ptr<Entry> entry_of(const std::string& key);

  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<Entry>> entries_;
  std::deque<std::shared_ptr<Entry>> last_;  // in the order of their use
};

}  // namespace ensonify
