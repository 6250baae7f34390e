#include "synthesis/carriers.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/random.h"
#include "core/units.h"

namespace ensonify {
namespace {

constexpr double kPerDb = 2.302585092994045684 / 20;  // ln 10 / 20

template <class Rows>
void copy_beams(const GroupBeams& beams, std::size_t samples, const Rows& from, Rows& to) {
  if (from.size() == 0) return;
  for (int k = 0; k < beams.count; ++k) {
    const std::size_t first = static_cast<std::size_t>(beams.first + k * beams.step) * samples;
    std::copy_n(from.data() + first, samples, to.data() + first);
  }
}

class CarrierBackend final : public Backend {
 public:
  CarrierBackend(const SynthesisSetup& setup, const MakeCarrier& make) : setup_(setup) {
    for (int group = 0; group < group_count(setup.sonar); ++group) {
      SynthesisSetup own = setup;
      shift_carriers(own.sonar, carrier_hz(setup.sonar, group) - setup.sonar.frequency_hz);
      backends_.push_back(make(own));
    }
  }

  SynthesisMemory memory(bool has_volumes) const override {
    SynthesisMemory all;
    for (const auto& backend : backends_) {
      const SynthesisMemory one = backend->memory(has_volumes);
      all.shared_bytes += one.shared_bytes;
      all.ping_bytes = std::max(all.ping_bytes, one.ping_bytes);
      all.echo_bytes = std::max(all.echo_bytes, one.echo_bytes);
      all.thread_bytes = std::max(all.thread_bytes, one.thread_bytes);
    }
    const std::uint64_t pixels = std::uint64_t(setup_.sonar.beam_count) * setup_.record.samples;
    all.ping_bytes += pixels * (sizeof(std::complex<float>) + sizeof(float));
    if (has_volumes) all.ping_bytes += pixels * 3 * sizeof(float);
    all.echo_bytes += sizeof(Scatterer);
    return all;
  }

  std::uint64_t missing_bytes(std::uint64_t scatterers, bool has_volumes) const override {
    std::uint64_t missing = 0;
    for (const auto& backend : backends_) {
      missing = std::max(missing, backend->missing_bytes(scatterers, has_volumes));
    }
    return missing;
  }

  int draws_at_once() const override { return backends_.front()->draws_at_once(); }

  void synthesize(std::span<const PingTask> tasks, std::span<PingSeries> series,
                  const Workers& workers) const override {
    std::vector<PingSeries> heard(tasks.size());
    for (int group = 0; group < group_count(setup_.sonar); ++group) {
      synthesize_group(group, tasks, group == 0 ? series : std::span(heard), workers);
      for (std::size_t i = 0; i < tasks.size() && group > 0; ++i) {
        const GroupBeams beams = beams_of_group(setup_.sonar, group);
        const std::size_t samples = setup_.record.samples;
        copy_beams(beams, samples, heard[i].pressure_pa, series[i].pressure_pa);
        copy_beams(beams, samples, heard[i].clean_power_pa2, series[i].clean_power_pa2);
      }
    }
  }

 private:
  // All beams, as if the group had all of them.
  void synthesize_group(int group, std::span<const PingTask> tasks, std::span<PingSeries> series,
                        const Workers& workers) const {
    const std::vector<double> more_db_m = more_absorption_db_m(setup_.sonar, setup_.water, group);
    // Realizations of one scene share their scatterers and volumes, and so do their copies.
    std::map<const ScattererList*, ScattererList> lists;
    std::map<const VolumeEcho*, std::vector<VolumeEcho>> volumes;
    std::vector<PingTask> own(tasks.begin(), tasks.end());
    for (PingTask& task : own) {
      task.only_level = false;
      task.keys.volume = mix64(task.keys.volume + static_cast<std::uint64_t>(group));
      if (more_db_m.empty()) continue;
      const auto [list, is_new] = lists.try_emplace(task.scatterers, *task.scatterers);
      if (is_new) absorb(list->second, setup_.water, more_db_m);
      task.scatterers = &list->second;
      auto& copies = volumes[task.volumes.data()];
      if (copies.empty()) {
        copies.assign(task.volumes.begin(), task.volumes.end());
        for (VolumeEcho& copy : copies) absorb(copy, setup_.sonar, setup_.water, more_db_m);
      }
      task.volumes = copies;
    }
    backends_[static_cast<std::size_t>(group)]->synthesize(own, series, workers);
  }

  SynthesisSetup setup_;
  std::vector<std::unique_ptr<Backend>> backends_;
};

}  // namespace

void shift_carriers(Sonar& sonar, double by_hz) {
  sonar.frequency_hz += by_hz;
  for (PulseTableRow& row : sonar.pulse.table) row.frequency_hz += by_hz;
  if (!sonar.transmit) return;
  for (double& carrier_hz : sonar.transmit->frequency_hz) carrier_hz += by_hz;
}

void absorb(ScattererList& list, const Water& water, std::span<const double> more_db_m) {
  for (Scatterer& s : list.items) {
    const double path_m = water.sound_speed_m_s * (s.delay_s - double{s.lag_s});
    s.gain *= static_cast<float>(std::exp(-kPerDb * more_db_m[s.beam] * path_m));
  }
}

void absorb(VolumeEcho& volume, const Sonar& sonar, const Water& water,
            std::span<const double> more_db_m) {
  const std::size_t samples = volume.energy.size() / more_db_m.size();
  for (std::size_t i = 0; i < volume.energy.size(); ++i) {
    const double path_m = 2 * sample_range_m(sonar, water, static_cast<int>(i % samples));
    volume.energy[i] *= static_cast<float>(std::exp(-2 * kPerDb * more_db_m[i / samples] * path_m));
  }
}

std::vector<double> more_absorption_db_m(const Sonar& sonar, const Water& water, int group) {
  const std::vector<double>& of_group = water.group_absorption_db_m;
  if (std::ranges::all_of(of_group, [&](double db_m) { return db_m == water.absorption_db_m; })) {
    return {};
  }
  std::vector<double> more_db_m;
  for (int beam = 0; beam < sonar.beam_count; ++beam) {
    const double own = of_group[static_cast<std::size_t>(group_of(sonar, beam))];
    more_db_m.push_back(group < 0 ? own - water.absorption_db_m
                                  : of_group[static_cast<std::size_t>(group)] - own);
  }
  return more_db_m;
}

std::unique_ptr<Backend> make_carrier_backend(const SynthesisSetup& setup,
                                              const MakeCarrier& make) {
  if (!setup.sonar.transmit || setup.sonar.transmit->frequency_hz.empty()) return make(setup);
  return std::make_unique<CarrierBackend>(setup, make);
}

}  // namespace ensonify
