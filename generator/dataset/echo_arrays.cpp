#include "dataset/echo_arrays.h"

#include <cstdint>

#include "core/error.h"
#include "formats/bytes.h"
#include "formats/npy.h"

namespace ensonify {

const char* const kNpyScatterer =
    "[('delay_s', '<f8'), ('beam', '<i4'), ('azimuth_rad', '<f4'), ('elevation_rad', '<f4'), "
    "('amp_re', '<f4'), ('amp_im', '<f4'), ('mean_re', '<f4'), ('mean_im', '<f4'), "
    "('variance', '<f4'), ('gain', '<f4'), ('cos_incidence', '<f4'), ('doppler', '<f4'), "
    "('instance', '<u4'), ('path', '<u2'), ('x', '<f8'), ('y', '<f8'), ('z', '<f8')]";

const char* const kNpyVia = "[('via', '<u2', (3,))]";
static_assert(kMostBounces == 3);

const char* const kNpyElevation =
    "[('sample', '<i4'), ('beam', '<u2'), ('step', '<i2'), ('offset', '<f4'), ('diffuse_pa2', "
    "'<f4'), ('coherent_pa', '<c8'), ('instance', '<u2'), ('path', '<u2')]";
static_assert(sizeof(ElevationEcho) == 28);

std::string encode_scatterers(const ScattererList& scatterers,
                              std::span<const std::complex<float>> amplitudes,
                              const Pose& sonar_in_world) {
  ENSONIFY_ASSERT(amplitudes.size() == scatterers.size());
  std::string bytes = npy_header(kNpyScatterer, {scatterers.size()});
  const std::size_t header = bytes.size();
  bytes.resize(header + kScattererBytes * scatterers.size());
  char* at = bytes.data() + header;
  for (std::size_t i = 0; i < scatterers.size(); ++i) {
    const Scatterer& s = scatterers.items[i];
    put_value(at, s.delay_s);
    put_value(at, static_cast<std::int32_t>(s.beam));
    put_value(at, s.arrival.azimuth_rad);
    put_value(at, s.arrival.elevation_rad);
    put_value(at, amplitudes[i].real());
    put_value(at, amplitudes[i].imag());
    put_value(at, s.mean.real());
    put_value(at, s.mean.imag());
    put_value(at, s.standard_deviation * s.standard_deviation);
    put_value(at, s.gain);
    put_value(at, s.cos_incidence);
    put_value(at, s.doppler);
    put_value(at, s.instance);
    put_value(at, s.path);
    const Vec3 world = transform_point(sonar_in_world, s.position_m);
    put_value(at, world.x);
    put_value(at, world.y);
    put_value(at, world.z);
  }
  return bytes;
}

std::string encode_via(const ScattererList& scatterers) {
  std::string bytes = npy_header(kNpyVia, {scatterers.size()});
  const std::size_t header = bytes.size();
  bytes.resize(header + sizeof(Scatterer::via) * scatterers.size());
  char* at = bytes.data() + header;
  for (const Scatterer& s : scatterers.items) {
    for (const std::uint16_t instance : s.via) put_value(at, instance);
  }
  return bytes;
}

std::string encode_elevation(std::span<const ElevationEcho> echoes) {
  std::string bytes = npy_header(kNpyElevation, {echoes.size()});
  bytes.append(static_cast<const char*>(static_cast<const void*>(echoes.data())),
               echoes.size_bytes());
  return bytes;
}

}  // namespace ensonify
