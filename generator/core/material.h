// How a surface throws sound back: the parameters, without the formulas (acoustics/scattering.h).
#pragma once

#include <cstdint>
#include <vector>

namespace ensonify {

enum class ScatteringLaw { lambert, lommel_seeliger, table };
enum class CoherentModel { none, rician, kirchhoff };

// Measured backscatter strength against grazing angle (0: along the surface).
struct BackscatterTable {
  std::vector<double> grazing_rad;  // rising, from 0 to pi/2
  std::vector<double> strength_db;  // dB re 1 m^2/m^2 per steradian of backscatter
};

struct Material {
  ScatteringLaw law = ScatteringLaw::lambert;
  double reflectivity = 0;      // mu, of lambert and lommel_seeliger
  double lambert_exponent = 1;  // n
  BackscatterTable table{};
  CoherentModel coherent = CoherentModel::none;
  double rician_k = 0;         // K, power ratio of the constant part to the random one
  double reflection = 0;       // R of kirchhoff, -1 ... 1
  double roughness_rms_m = 0;  // h of kirchhoff
};

// Parts of a mesh that scatter in another way than the rest of their object.
struct PartMaterials {
  std::vector<std::uint16_t> of_part;  // by Mesh::part: 0 the object's own, k: materials[k - 1]
  std::vector<Material> materials;     // both empty: the object's own everywhere
};

}  // namespace ensonify
