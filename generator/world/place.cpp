#include "world/place.h"

namespace ensonify {

Status place_objects(const Scenario&, std::uint32_t, World&) { return {}; }

}  // namespace ensonify
