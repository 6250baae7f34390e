#include "ping/array_receiver.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "acoustics/pattern.h"
#include "core/random.h"
#include "core/units.h"
#include "scenario/rig.h"

namespace ensonify {
namespace {

// The limit is the same as for the pixels of a ping.
constexpr double kMaxChannelSamples = 268435456.0;  // 2^28

Error refused(const std::string& key, const std::string& trouble) {
  return {ErrorKind::usage, fmt::format("sonar.receiver.{}: {}", key, trouble)};
}

// The aperture is that of the beam width.
double elements_for_width(const ArrayReceiver& array, const Sonar& sonar, double wavelength_m) {
  const double aperture = make_shaded_line(array.shading, sonar.beam_width_rad).aperture;
  return std::max(1.0, std::round(aperture * wavelength_m / array.spacing_m));
}

std::vector<std::complex<double>> responses(const ArraySpec& spec, int elements,
                                            std::uint64_t seed) {
  const std::uint64_t key = stream_key(seed, Stream::array, 0);
  std::vector<std::complex<double>> response;
  for (int n = 0; n < elements; ++n) {
    const ComplexDraw xi = complex_normal(key, 0, static_cast<std::uint64_t>(n), 0);
    const double gain_db = std::sqrt(2.0) * xi.re * spec.gain_error_db;
    const double phase_rad = std::sqrt(2.0) * xi.im * radians(spec.phase_error_deg);
    response.push_back(std::polar(std::pow(10.0, gain_db / 20), phase_rad));
  }
  for (const int n : spec.dead) response[static_cast<std::size_t>(n)] = 0;
  return response;
}

}  // namespace

Result<std::optional<ArrayReceiver>> array_receiver(const Scenario& scenario, const Sonar& sonar,
                                                    const Water& water, const Record& record) {
  using Receiver = std::optional<ArrayReceiver>;
  if (!scenario.sonar.array) return Receiver();
  const ArraySpec& spec = *scenario.sonar.array;
  const double wavelength_m = water.sound_speed_m_s / sonar.frequency_hz;
  ArrayReceiver array;
  array.spacing_m = spec.spacing_m.value_or(wavelength_m / 2);
  array.element_width_m = spec.element_width_m;
  array.shading = spec.shading.value_or(sonar.shading);
  array.focus = spec.focus;
  array.steering = spec.steering;
  if (!spec.elements) {
    const double elements = elements_for_width(array, sonar, wavelength_m);
    if (elements > kMaxElements) {
      return refused(
          "elements",
          fmt::format("a beam of {:.4g} degrees needs {:.0f} elements {:.4g} m apart; expected at "
                      "most {} (give elements or a larger spacing_m)",
                      degrees(sonar.beam_width_rad), elements, array.spacing_m, kMaxElements));
    }
    array.elements = static_cast<int>(elements);
  } else {
    array.elements = *spec.elements;
  }
  if (double(array.elements) * record.samples > kMaxChannelSamples) {
    return refused(
        "elements",
        fmt::format("{} elements of {} samples exceed 2^28 (268435456) samples per ping; expected "
                    "fewer elements or a lower range_max_m or bandwidth_hz",
                    array.elements, record.samples));
  }
  if (const std::string trouble = dead_trouble(spec.dead, array.elements); !trouble.empty()) {
    return refused("dead", trouble);
  }
  array.response = responses(spec, array.elements, device_seed(scenario));
  return Receiver(std::move(array));
}

}  // namespace ensonify
