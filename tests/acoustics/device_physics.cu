// Compiles every inline function of one scatterer's physics into a kernel, so that a host-only
// call in one of them fails the build.
#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "acoustics/scattering.h"
#include "core/random.h"
#include "core/units.h"
#include "core/vec.h"

namespace ensonify {

__global__ void one_scatterer(const double* in, double* out) {
  const double range = in[0], incidence = in[1], azimuth = in[2], elevation = in[3];
  const double cross_section = range * range * cell_solid_angle_sr(in[6], in[7], in[8]);
  const ScattererMoments moments = rician_moments(in[4] * incidence * cross_section, in[5]);
  const ComplexDraw xi = complex_normal(stream_key(1, Stream::speckle, 2), 3, 4, 5);
  out[0] = (moments.mean_m + sqrt(moments.variance_m2) * xi.re) * two_way_loss(range, in[9]) *
           line_pattern(elevation, in[10]);
  out[1] = carrier_turns(in[11], two_way_delay_s(range, in[12]));
  out[2] = target_amplitude_m(in[13]) + level_db(mean_square_pa2(in[14])) + radians(azimuth);
  const Vec3 p = transform_point({{range, azimuth, 0}, {}}, {1, 2, 3});
  out[3] = dot(p, normalized(cross(p, {0, 0, 1})));
  ShadedLine pattern;
  pattern.shading.kind = static_cast<Shading>(static_cast<int>(in[15]));
  pattern.aperture = in[16];
  out[4] = shaded_pattern(pattern, azimuth) * transmit_pattern(azimuth, in[17]);
  out[5] = coherent_reflection(in[18], in[19], in[20], incidence);
}

}  // namespace ensonify
