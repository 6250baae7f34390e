#include "synthesis/array.h"

#include "core/error.h"

namespace ensonify {

ArrayGeometry make_array_geometry(const Sonar& sonar) {
  ENSONIFY_ASSERT(sonar.array.has_value());
  const ArrayReceiver& array = *sonar.array;
  ENSONIFY_ASSERT(array.response.size() == static_cast<std::size_t>(array.elements));
  ArrayGeometry geometry;
  for (int n = 0; n < array.elements; ++n) {
    geometry.y_m.push_back((n - (array.elements - 1) / 2.0) * array.spacing_m);
  }
  geometry.weight = array_weights(array.shading, array.elements);
  geometry.response = array.response;
  return geometry;
}

}  // namespace ensonify
