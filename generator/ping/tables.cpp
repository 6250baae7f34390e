#include "ping/tables.h"

#include <fmt/format.h>

#include <cmath>
#include <complex>
#include <cstdlib>

#include "acoustics/pulse.h"
#include "camera/view.h"
#include "core/units.h"
#include "labels/cartesian.h"
#include "labels/shadow.h"
#include "ping/ping_echoes.h"
#include "synthesis/beamforming.h"
#include "synthesis/carriers.h"
#include "synthesis/cuda_backend.h"

namespace ensonify {

Result<Numerics> settle_backend(BackendChoice choice, SimdLevel simd) {
  if (choice == BackendChoice::reference) return Numerics{choice, simd, "reference"};
  const bool may_be_cuda = choice == BackendChoice::cuda ||
                           (choice == BackendChoice::automatic && may_have_cuda_device());
  if (!may_be_cuda) return Numerics{BackendChoice::cpu, simd, "cpu"};
  const Result<std::vector<CudaDeviceInfo>> devices = cuda_devices();
  if (!devices && choice == BackendChoice::cuda) return devices.error();
  if (!devices) {
    return Numerics{BackendChoice::cpu, simd, "cpu", false, devices.error().message};
  }
  return Numerics{BackendChoice::cuda, simd, "cuda, " + devices->front().name,
                  choice == BackendChoice::automatic};
}

std::unique_ptr<Backend> make_backend(const Numerics& numerics, const SynthesisSetup& setup) {
  ENSONIFY_ASSERT(numerics.backend != BackendChoice::automatic);
  return make_carrier_backend(setup, [&](const SynthesisSetup& own) -> std::unique_ptr<Backend> {
    if (numerics.backend == BackendChoice::reference) return make_reference_backend(own);
    if (numerics.backend == BackendChoice::cpu) return make_cpu_backend(own);
    Result<std::unique_ptr<Backend>> backend = make_cuda_backend(own);
    if (!backend) throw DeviceFailure(backend.error().message);
    return std::move(*backend);
  });
}

std::string numerics_name(SimdLevel used) {
  std::string name(simd_level_name(used));
  if (used != best_simd_level()) {
    name += " on " + std::string(simd_level_name(best_simd_level()));
  }
  return name;
}

namespace {

double relative_energy(const Sonar& sonar, int cell, int beam) {
  return cell_width_rad(sonar, cell) / cell_width_rad(sonar, beam);
}

double beam_model_power(const Sonar& sonar, const Mixing& mixing, double source_pa_m, int beam) {
  double sum = 0;
  for (int i = 0; i < mixing.beams(); ++i) {
    sum += mixing.at(beam, i) * mixing.at(beam, i) * relative_energy(sonar, i, beam);
  }
  const double amplitude = source_pa_m * mixing.scale[beam];
  return amplitude * amplitude * sum;
}

// For a focused array at the carrier, the sum over elements is a polynomial in the phase step from
// one element to the next.
double array_power(const Sonar& sonar, const ArrayGeometry& array, double wavelength_m, int beam) {
  const double steered = std::sin(beam_azimuth_rad(sonar, beam));
  double power = 0;
  for (int i = 0; i < sonar.beam_count; ++i) {
    const double u = std::sin(cell_middle_rad(sonar, i));
    const std::complex<double> turn =
        std::polar(1.0, 2 * kPi * sonar.array->spacing_m * (u - steered) / wavelength_m);
    std::complex<double> sum = 0;
    for (std::size_t n = array.weight.size(); n-- > 0;) {
      sum = sum * turn + array.weight[n] * array.response[n];
    }
    const double heard = element_pattern(u, sonar.array->element_width_m, wavelength_m);
    power += heard * heard * std::norm(sum) * relative_energy(sonar, i, beam);
  }
  return power;
}

}  // namespace

HiddenPower hidden_power(const Sonar& sonar, const Water& water, const Record& record) {
  HiddenPower power;
  const Mixing mixing = make_mixing(sonar);
  const double source_pa_m = source_pressure_pa_m(sonar);
  const ArrayGeometry array = sonar.array ? make_array_geometry(sonar) : ArrayGeometry{};
  const double wavelength_m = water.sound_speed_m_s / sonar.frequency_hz;
  for (int j = 0; j < sonar.beam_count; ++j) {
    power.per_energy.push_back(sonar.array ? source_pa_m * source_pa_m *
                                                 array_power(sonar, array, wavelength_m, j)
                                           : beam_model_power(sonar, mixing, source_pa_m, j));
  }
  constexpr int kHalf = kPulseSteps / 2;  // steps per sample
  const std::vector<double> square =
      envelope_squared(pulse_spectrum(sonar, record.transform), kHalf);
  const int count = static_cast<int>(square.size());
  for (int k = -kHalf; k <= kHalf; ++k) power.pulse.push_back(square[(k + count) % count]);
  return power;
}

PowerSpread power_spread(const Sonar& sonar, const Record& record) {
  PowerSpread spread;
  const Mixing mixing = make_mixing(sonar);
  spread.beam.reserve(std::size_t(sonar.beam_count) * sonar.beam_count);
  for (int j = 0; j < sonar.beam_count; ++j) {
    for (int i = 0; i < sonar.beam_count; ++i) {
      const double weight = mixing.scale[j] * mixing.at(j, i);
      spread.beam.push_back(static_cast<float>(weight * weight));
    }
  }
  for (const std::complex<double>& q :
       pulse_autospectrum(pulse_spectrum(sonar, record.transform))) {
    spread.pulse.emplace_back(q);
  }
  return spread;
}

bool needs_footprints(const OutputSpec& output) {
  return output.selection.png && output.selection.cartesian &&
         output.png.resampling == Resampling::bilinear;
}

namespace {

std::shared_ptr<const PipelineTables> make_tables(const Session& session, const Numerics& numerics,
                                                  const DopplerRange& doppler) {
  auto tables = std::make_shared<PipelineTables>();
  tables->fan = make_fan(session.sonar);
  tables->backend = make_backend(
      numerics, {session.sonar, session.water, session.record, session.scenario.synthesis_tolerance,
                 numerics.simd, doppler.lowest, doppler.highest});
  if (session.scenario.output.selection.cartesian) {
    const CartesianGrid grid =
        cartesian_grid(session.sonar, session.scenario.output.cartesian_height_px);
    tables->cartesian_map = cartesian_map(grid, session.sonar, session.water, session.record);
    if (needs_footprints(session.scenario.output)) {
      tables->footprints =
          footprints(grid, session.sonar, session.water, session.record, tables->cartesian_map);
    }
  }
  if (session.scenario.noise_correlated) tables->beam_noise.emplace(session.sonar);
  const auto& detector = session.sonar.detector;
  if (detector && detector->looks > 1) tables->sub_bands.emplace(session.sonar, session.record);
  if (session.scenario.output.selection.any_camera()) {
    tables->camera_rays = camera_rays(optics_of(*session.scenario.camera));
  }
  tables->hidden_power = hidden_power(session.sonar, session.water, session.record);
  return tables;
}

}  // namespace

std::string table_key(const Scenario& scenario) {
  Scenario part = scenario;
  part.drawn_sections.reset();  // as sampled, not as a distribution
  const Scenario none;
  part.name = none.name;
  part.sequences = none.sequences;
  part.speckle_seed = none.speckle_seed;
  // It keys the errors of an array.
  part.seed = scenario.sonar.array ? device_seed(scenario) : none.seed;
  part.rig = none.rig;  // the text then has the sonar of the instrument
  part.instrument = none.instrument;
  part.sonar.mount = none.sonar.mount;
  part.scattering.lambert_exponent = none.scattering.lambert_exponent;
  part.scattering.speckle = none.scattering.speckle;
  part.materials = none.materials;
  part.objects = none.objects;
  part.point_targets = none.point_targets;
  part.volumes = none.volumes;
  part.classes = none.classes;
  part.multipath = none.multipath;
  part.bounces = none.bounces;
  // Values that depend on motion are in the key of pipeline_tables.
  part.trajectory = none.trajectory;
  part.motion_within_ping = none.motion_within_ping;
  part.navigation = none.navigation;
  part.noise_spectrum_level_db = none.noise_spectrum_level_db;
  part.noise_snr_db = none.noise_snr_db;
  part.sonar.electronics = none.sonar.electronics;
  part.sonar.recorder = none.sonar.recorder;
  if (part.sonar.detector) {
    Detector looks;
    looks.looks = part.sonar.detector->looks;
    part.sonar.detector = looks.looks > 1 ? std::optional(looks) : std::nullopt;
  }
  part.output.png_db = none.output.png_db;
  part.output.png = none.output.png;
  part.output.png.resampling =
      needs_footprints(scenario.output) ? Resampling::bilinear : Resampling::nearest;
  part.output.layer_targets = none.output.layer_targets;
  part.output.sdf = none.output.sdf;
  part.output.height_map = none.output.height_map;
  part.output.selection = none.output.selection;
  part.output.selection.cartesian = scenario.output.selection.cartesian;
  if (!scenario.output.selection.any_camera()) part.camera.reset();
  part.splits = none.splits;
  const std::string key =
      to_yaml(part, [](const std::filesystem::path& file) { return file.string(); });
  // The text has no section for noise without its level.
  return scenario.noise_correlated ? key + "noise: correlated\n" : key;
}

std::shared_ptr<const PipelineTables> pipeline_tables(const Session& session,
                                                      const Numerics& numerics) {
  const DopplerRange doppler = doppler_range(session);
  const auto make = [&] { return make_tables(session, numerics, doppler); };
  if (!numerics.tables) return make();
  const std::string key = fmt::format("{}doppler {} {} {}\n", table_key(session.scenario),
                                      doppler.lowest, doppler.highest, numerics.backend_name);
  return numerics.tables->of(key, make);
}

}  // namespace ensonify
