#include "acoustics/scattering.h"

#include <cmath>
#include <set>
#include <string_view>
#include <vector>

#include "acoustics/propagation.h"
#include "catch.h"
#include "core/units.h"
#include "core/vec.h"

using namespace ensonify;

namespace {

double cos_of(double incidence_deg) { return std::cos(radians(incidence_deg)); }

Material lambert(double reflectivity, double exponent) {
  Material material;
  material.reflectivity = reflectivity;
  material.law = Lambert{exponent};
  return material;
}

Material lommel_seeliger(double reflectivity) {
  Material material;
  material.law = LommelSeeliger{};
  material.reflectivity = reflectivity;
  return material;
}

Material tabulated() {
  Material material;
  material.law =
      MeasuredStrength{{}, {{0, radians(10), radians(40), radians(90)}, {-50, -35, -29, -9}}};
  return material;
}

// Each law at least once.
std::vector<Material> of_all_laws() {
  std::vector<Material> materials = {lambert(1e-3, 1), lambert(1e-3, 2), lambert(1e-3, 2.5),
                                     lommel_seeliger(1e-3), tabulated()};
  std::set<std::string_view> words;
  for (const Material& material : materials) words.insert(name_of(material.law));
  CHECK(words.size() == kLawCount);
  return materials;
}

}  // namespace

// Protects levels against ray density: cells add up to the whole solid angle, 4 pi for a sphere.
TEST_CASE("cells of the fan tile the sphere") {
  double sum = 0;
  const int azimuths = 90, elevations = 45;
  for (int e = 0; e < elevations; ++e) {
    const double low = -kPi / 2 + e * kPi / elevations;
    sum += azimuths * cell_solid_angle_sr(2 * kPi / azimuths, low, low + kPi / elevations);
  }
  CHECK(sum == Approx(4 * kPi).epsilon(1e-12));
}

TEST_CASE("target strength is 20 log of the amplitude") {
  CHECK(target_amplitude_m(-40) == Approx(0.01));
}

// Protects the laws at angles whose cosines are known: 60 degrees, 0.5; 45 degrees, sqrt(0.5).
TEST_CASE("scattering laws at chosen angles") {
  CHECK(backscatter_strength(lambert(1e-3, 1), cos_of(60)) == Approx(1e-3 / 4));
  CHECK(backscatter_strength(lambert(1e-3, 2), cos_of(60)) == Approx(1e-3 / 8));
  CHECK(backscatter_strength(lambert(1e-3, 0), cos_of(60)) == Approx(1e-3 / 2));
  CHECK(backscatter_strength(lommel_seeliger(1e-3), cos_of(60)) == Approx(1e-3 / 2));
  CHECK(backscatter_strength(lommel_seeliger(1e-3), cos_of(45)) == Approx(1e-3 * std::sqrt(0.5)));
  // All but the table have mu at normal incidence.
  CHECK(backscatter_strength(lambert(1e-3, 1.7), 1) == Approx(1e-3));
  CHECK(backscatter_strength(lommel_seeliger(1e-3), 1) == Approx(1e-3));
}

// Protects measured tables: rows are met, values between are linear in dB against grazing angle,
// and the ends hold although the cosine of 90 degrees is not quite 0.
TEST_CASE("a backscatter table is linear in dB between its rows") {
  const Material sand = tabulated();
  const auto strength_db = [&](double grazing_deg) {
    return 10 * std::log10(backscatter_strength(sand, std::sin(radians(grazing_deg))));
  };
  for (const auto& [grazing_deg, expected_db] : {std::pair{0.0, -50.0},
                                                 {10.0, -35.0},
                                                 {40.0, -29.0},
                                                 {90.0, -9.0},
                                                 {5.0, -42.5},
                                                 {25.0, -32.0},
                                                 {65.0, -19.0}}) {
    INFO(grazing_deg << " degrees");
    CHECK(strength_db(grazing_deg) == Approx(expected_db).epsilon(1e-9));
  }
}

// Protects sigma^2 = factor s_b dA / cos(alpha): from the strength and the area that the ray
// covers.
TEST_CASE("a scatterer's variance is the strength of the patch that its ray covers") {
  const double range_m = 2, solid_angle_sr = 0.1;
  for (const Material& material : of_all_laws()) {
    for (const double incidence_deg : {0.0, 30.0, 60.0, 85.0}) {
      const double c = cos_of(incidence_deg);
      const double patch_m2 = range_m * range_m * solid_angle_sr / c;
      const ScattererMoments moments =
          scatterer_moments(material, 0.25, c, range_m, solid_angle_sr);
      CHECK(moments.mean_m == 0);
      CHECK(moments.variance_m2 == Approx(0.25 * backscatter_strength(material, c) * patch_m2));
    }
  }
  CHECK(scatterer_moments(lambert(1e-3, 1), 1, 0.5, 2, 0.1).variance_m2 ==
        Approx(1e-3 * 0.5 * 4 * 0.1));
  CHECK(scatterer_moments(lambert(1e-3, 2), 1, 0.5, 2, 0.1).variance_m2 ==
        Approx(1e-3 * 0.25 * 4 * 0.1));
}

// Protects rays that graze exactly: a number where the law gives one, and one that a caller can
// tell where it does not.
TEST_CASE("variance along the surface") {
  CHECK(scatterer_moments(lambert(1e-3, 1), 1, 0, 2, 0.1).variance_m2 == 0);
  CHECK(scatterer_moments(lambert(1e-3, 0), 1, 0, 2, 0.1).variance_m2 == Approx(1e-3 * 4 * 0.1));
  CHECK(scatterer_moments(lommel_seeliger(1e-3), 1, 0, 2, 0.1).variance_m2 ==
        Approx(1e-3 * 4 * 0.1));
  CHECK_FALSE(std::isfinite(scatterer_moments(tabulated(), 1, 0, 2, 0.1).variance_m2));
}

// Protects mean levels: the constant part takes energy from the random one and adds none, and
// without it the surface is the diffuse one.
TEST_CASE("a rician surface keeps its energy") {
  const double diffuse = scatterer_moments(lambert(1e-3, 1), 0.7, 0.6, 3, 0.02).variance_m2;
  for (const double k : {0.0, 0.5, 1.0, 20.0}) {
    Material material = lambert(1e-3, 1);
    material.coherent = CoherentModel::rician;
    material.rician_k = k;
    const ScattererMoments moments = scatterer_moments(material, 0.7, 0.6, 3, 0.02);
    CHECK(moments.mean_m * moments.mean_m + moments.variance_m2 == Approx(diffuse).epsilon(1e-14));
    CHECK(moments.mean_m * moments.mean_m == Approx(k * moments.variance_m2).margin(1e-20));
    CHECK(moments.mean_m >= 0);
  }
}

// Protects the two kinds of energy against each other: a mirror's echo is not in its random part.
TEST_CASE("a mirror's random part has no mean") {
  Material material = lambert(1e-3, 1);
  material.coherent = CoherentModel::kirchhoff;
  material.reflection = 1;
  material.rician_k = 3;
  const ScattererMoments moments = scatterer_moments(material, 1, 0.6, 3, 0.02);
  CHECK(moments.mean_m == 0);
  CHECK(moments.variance_m2 == scatterer_moments(lambert(1e-3, 1), 1, 0.6, 3, 0.02).variance_m2);
}

// Protects the mirror's formula by Kirchhoff's integral, (i/lambda) R integral of
// cos(alpha) e^(-i 2k(r - r_0)) dS, summed over a tilted plane cell of real points at a real range.
// The cell is so small that its range is linear to 5e-4 rad.
TEST_CASE("a mirror's cell is Kirchhoff's integral over it") {
  const double wavelength = 1500 / 900e3, k = 2 * kPi / wavelength;
  const Vec3 middle{6, 1, -2};
  const double range = length(middle);
  Material mirror;
  mirror.coherent = CoherentModel::kirchhoff;
  mirror.reflection = -0.8;
  for (const auto& [u, v] : {std::pair{Vec3{0, 3e-3, 0}, Vec3{0, 0, 2e-3}},
                             {Vec3{1e-3, 3e-3, 0}, Vec3{-0.5e-3, 0, 2e-3}},
                             {Vec3{2e-3, 2e-3, 0}, Vec3{1.2e-3, 0.3e-3, 2e-3}}}) {
    const Vec3 normal = normalized(cross(u, v));
    const double area = length(cross(u, v));
    const double cos_incidence = std::abs(dot(normalized(middle), normal));
    constexpr int kPoints = 200;
    std::complex<double> integral = 0;
    for (int i = 0; i < kPoints; ++i) {
      for (int j = 0; j < kPoints; ++j) {
        const Vec3 point =
            middle + ((i + 0.5) / kPoints - 0.5) * u + ((j + 0.5) / kPoints - 0.5) * v;
        integral += std::polar(1.0, -2 * k * (length(point) - range));
      }
    }
    integral *= area * cos_incidence / (kPoints * kPoints);
    const std::complex<double> expected =
        std::complex<double>(0, 1 / wavelength) * mirror.reflection * integral;
    const double across_u = length(middle + 0.5 * u) - length(middle - 0.5 * u);
    const double across_v = length(middle + 0.5 * v) - length(middle - 0.5 * v);
    const std::complex<double> cell =
        kirchhoff_amplitude_m(mirror, wavelength, cos_incidence, range,
                              area * cos_incidence / (range * range), across_u, across_v);
    CHECK(std::abs(cell - expected) < 1e-3 * area / wavelength);
    CHECK(std::abs(cell) > 0.01 * area / wavelength);
  }
}

// Protects V18's level: a mirror that faces the sonar has TS = 20 log10(A/lambda).
TEST_CASE("a facing mirror's cell is its area over the wavelength") {
  Material mirror;
  mirror.reflection = 1;
  const std::complex<double> a = kirchhoff_amplitude_m(mirror, 2e-3, 1, 10, 1e-6, 0, 0);
  CHECK(a.real() == 0);
  CHECK(a.imag() == Approx(1e-4 / 2e-3));
}

// Protects the roughness factor by what it stands for: the mean of e^(i 2k h cos(alpha) x) over
// normal heights of rms h, by its integral.
TEST_CASE("roughness takes from a mirror what its random heights put out of phase") {
  const double wavelength = 1.6e-3, rms = 0.2e-3;
  for (const double incidence_deg : {0.0, 50.0, 80.0}) {
    const double c = cos_of(incidence_deg), phase = 2 * (2 * kPi / wavelength) * rms * c;
    double mean = 0;
    for (double x = -8; x < 8; x += 1e-3) {
      mean += std::cos(phase * x) * std::exp(-x * x / 2) / std::sqrt(2 * kPi) * 1e-3;
    }
    CHECK(coherent_reflection(0.9, rms, wavelength, c) == Approx(0.9 * mean).epsilon(1e-8));
    Material rough, smooth;
    rough.reflection = smooth.reflection = 0.9;
    rough.roughness_rms_m = rms;
    CHECK(std::abs(kirchhoff_amplitude_m(rough, wavelength, c, 5, 1e-6, 0, 0)) ==
          Approx(mean * std::abs(kirchhoff_amplitude_m(smooth, wavelength, c, 5, 1e-6, 0, 0))));
  }
}

// Protects reciprocity, and that nothing changes where sound leaves the way it came.
TEST_CASE("bistatic strength is symmetric and backscatter where both directions are equal") {
  for (const Material& material : of_all_laws()) {
    for (const double a : {10.0, 45.0, 70.0}) {
      CHECK(bistatic_strength(material, cos_of(a), cos_of(a)) ==
            backscatter_strength(material, cos_of(a)));
      const auto same = bistatic_moments(material, 0.7, cos_of(a), cos_of(a), 5, 1e-3);
      CHECK(same.variance_m2 == scatterer_moments(material, 0.7, cos_of(a), 5, 1e-3).variance_m2);
      for (const double b : {0.0, 30.0, 80.0}) {
        CHECK(bistatic_strength(material, cos_of(a), cos_of(b)) ==
              Approx(bistatic_strength(material, cos_of(b), cos_of(a))));
      }
      CHECK(bistatic_strength(material, cos_of(a), cos_of(a + 1e-7)) ==
            Approx(backscatter_strength(material, cos_of(a))).epsilon(1e-5));
    }
  }
}

TEST_CASE("bistatic strength at chosen angles") {
  CHECK(bistatic_strength(lambert(1e-3, 1), 0.5, 0.8) == Approx(1e-3 * 0.4));
  CHECK(bistatic_strength(lambert(1e-3, 3), 0.5, 0.8) == Approx(1e-3 * 0.16));
  CHECK(bistatic_strength(lommel_seeliger(1e-3), 0.2, 0.6) == Approx(1e-3 * 0.3));
  // -29 dB at 40 and -35 dB at 10 degrees of grazing.
  CHECK(10 * std::log10(bistatic_strength(tabulated(), cos_of(50), cos_of(80))) == Approx(-32));
}

// An element of surface has an area; which of two rays found it does not matter.
TEST_CASE("an element throws back as much whichever ray found it") {
  const Material material = lambert(1e-3, 1);
  const double area = 0.01, r1 = 5, r2 = 8, c1 = 0.9, c2 = 0.3;
  CHECK(bistatic_moments(material, 1, c1, c2, r1, area * c1 / (r1 * r1)).variance_m2 ==
        Approx(bistatic_moments(material, 1, c2, c1, r2, area * c2 / (r2 * r2)).variance_m2));
  Material rician = material;
  rician.coherent = CoherentModel::rician;
  rician.rician_k = 3;
  const auto shared = bistatic_moments(rician, 1, c1, c2, r1, 1e-3);
  CHECK(shared.mean_m * shared.mean_m == Approx(3 * shared.variance_m2));
}

// Protects the sonar equation: 40 log r and 2 alpha r in the level.
TEST_CASE("two-way loss is 40 log r and absorption over both ways") {
  CHECK(20 * std::log10(two_way_loss(5, 0)) == Approx(-40 * std::log10(5)));
  CHECK(20 * std::log10(two_way_loss(10, 0.3)) == Approx(-40 - 0.3 * 20));
}

// Protects coherence at long range: the fraction of a turn keeps its digits after 72,000 turns.
TEST_CASE("carrier turns are reduced in double") {
  const double delay = two_way_delay_s(60, 1500);
  CHECK(carrier_turns(900e3, delay) == Approx(0).margin(1e-9));
  // A quarter of a wavelength further away: half a turn more on the way out and back.
  const double wavelength = 1500 / 900e3;
  CHECK(std::abs(carrier_turns(900e3, two_way_delay_s(60 + wavelength / 4, 1500))) ==
        Approx(0.5).margin(1e-9));
  CHECK(carrier_turns(900e3, two_way_delay_s(60 + wavelength / 10, 1500)) ==
        Approx(0.2).margin(1e-9));
}
